#pragma once

#include <cstdlib>
#include <string>

#include "tests/support/temporary_folder.h"

namespace relume::test {

/// Its view `look` shows the square root of the scene's colours, of which red is halved and blue
/// doubled.
inline constexpr const char* square_root_config = R"(ocio_profile_version: 1
strictparsing: true
roles: {default: raw, scene_linear: lin}
displays:
  screen:
    - !<View> {name: look, colorspace: shown}
colorspaces:
  - !<ColorSpace> {name: lin, bitdepth: 32f}
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace>
    name: shown
    bitdepth: 32f
    from_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
        - !<ExponentTransform> {value: [0.5, 0.5, 0.5, 1]}
)";

/// The output transform of ACES 1 for a video screen, from ACEScg; needs OpenColorIO 2.1.
inline constexpr const char* aces_config = R"(ocio_profile_version: 2
roles: {default: raw, scene_linear: ACEScg, aces_interchange: aces, cie_xyz_d65_interchange: xyz}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  screen:
    - !<View> {name: video, view_transform: video, display_colorspace: sRGB}
view_transforms:
  - !<ViewTransform>
    name: video
    from_scene_reference: !<BuiltinTransform>
      style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0
display_colorspaces:
  - !<ColorSpace> {name: xyz}
  - !<ColorSpace>
    name: sRGB
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}
colorspaces:
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace> {name: aces}
  - !<ColorSpace>
    name: ACEScg
    to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
)";

/// $OCIO is a file of `text` while this lives.
class ColorConfigFile {
 public:
  explicit ColorConfigFile(const char* text = square_root_config) {
    write_all(folder_.file("config.ocio"), text);
    setenv("OCIO", folder_.file("config.ocio").c_str(), 1);
  }
  ~ColorConfigFile() { unsetenv("OCIO"); }
  ColorConfigFile(const ColorConfigFile&) = delete;
  ColorConfigFile& operator=(const ColorConfigFile&) = delete;

  const TemporaryFolder& folder() const { return folder_; }

 private:
  TemporaryFolder folder_;
};

}  // namespace relume::test
