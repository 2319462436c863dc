#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/image/display_transform.h"
#include "core/simd/instruction_set.h"
#include "reduction/reduction.h"
#include "shadow/shadow.h"
#include "viewer/commands/frame_range.h"
#include "viewer/farm/team.h"
#include "viewer/frames/frame_recipe.h"
#include "viewer/session/prepare_options.h"

namespace relume {

// What each command can be told: plain data, every default written. command_line.cpp fills them.

/// Understood by every command.
struct CommonOptions {
  int threads = 0;  ///< 0 = all
  uint64_t seed = 0;
  bool quiet = false;
  bool verbose = false;
  bool json = false;           ///< print figures as JSON on stdout
  Team team{};                 ///< processes that share this command's work
  std::string command_line{};  ///< as it was given, without the program
};

struct DemoOptions {
  std::string scene = "hair";
  std::optional<std::filesystem::path> offscreen;  ///< write pictures here instead of a window
  PrepareOptions prepare;
};

struct ViewOptions {
  std::string input;  ///< scene or cache
  std::optional<std::filesystem::path> offscreen;
  std::optional<std::filesystem::path> script;
  std::optional<ShadowMethod> shadow;  ///< nothing: `automatic` in a window; `ray` in scripts
  std::optional<float> frame_ms;       ///< nothing: 40 ms, for scenes as they are prepared
  bool keep_records = false;           ///< the picture at rest is not refined
  float scale = 0;                     ///< of text and controls; 0 = as the display asks for
  PrepareOptions prepare;
};

struct PrepareCommandOptions {
  std::string scene;  ///< or an AOV image, where `channels` is set
  std::filesystem::path output;
  std::string channels;      ///< preset or file of a channel map; empty: `scene` is a scene
  int samples_per_side = 5;  ///< sub-pixels of the AOV image
  std::string proxy;         ///< scene with camera, lights and what casts the shadows
  PrepareOptions prepare;
};

struct SampleOptions {
  std::string scene;
  std::filesystem::path output;
  int samples_per_side = 5;
  int width = 0;  ///< pixels; 0 = the scene's
  int height = 0;
};

struct RenderOptions {
  std::string input;  ///< scene or cache
  std::filesystem::path output;
  std::optional<std::filesystem::path> lights;
  std::optional<FrameRange> frames;  ///< of animated lights, a file each
  ShadowMethod shadow = ShadowMethod::ray;
  bool reference = false;                                ///< all samples, traced shadows
  std::optional<std::filesystem::path> predicted_error;  ///< heatmap to write, PNG
  std::optional<std::filesystem::path> record_map;       ///< heatmap to write, PNG
  std::optional<float> exposure;
  std::optional<ToneCurve> curve;  ///< nothing: the display of $OCIO, or srgb without one
  InstructionSet instruction_set = InstructionSet::automatic;
  std::vector<FrameAov> aovs;  ///< beside the light, EXR
  PrepareOptions prepare;
};

struct ConvertOptions {
  std::string input;             ///< scene or cache
  std::filesystem::path output;  ///< .exr: deep records; .usda: lights
  std::optional<std::filesystem::path> lights;
  ShadowMethod shadow = ShadowMethod::ray;
  PrepareOptions prepare;
};

struct VerifyOptions {
  std::filesystem::path frame;
  std::optional<std::filesystem::path> cache;  ///< nothing: prepared again as the frame says
};

struct CompareOptions {
  std::filesystem::path image;
  std::filesystem::path reference;
  std::optional<std::filesystem::path> heatmap;
  double range = 0;            ///< of the heatmap; 0 = automatic
  std::optional<double> fail;  ///< exit 1 when eq. 7 over all pixels is above
};

/// Pixels.
struct PictureSize {
  int width = 0;
  int height = 0;
};

struct BenchOptions {
  std::vector<std::string> inputs{"hair"};  ///< scene or cache; several: all are caches
  int repeats = 5;
  bool frames_only = false;  ///< no preprocess, no shadows: a cache needs no scene then
  std::optional<std::filesystem::path> port_cycles;  ///< see PortCycles
  std::vector<PictureSize> sizes;  ///< compare frames of these with 1280x720, adaptive average 3
  PrepareOptions prepare;
};

struct StudyOptions {
  std::string name;                             ///< one of study_names
  std::vector<std::string> scenes;              ///< empty = the study's own
  std::optional<std::filesystem::path> output;  ///< folder for NAME.json, .csv, .html and pictures
  bool quick = false;                           ///< a part of the picture, fewer lights
  std::vector<ReductionMethod> methods;         ///< empty = the study's own
  std::vector<ShadowMethod> shadows;            ///< empty = the study's own
  std::vector<int> records;                     ///< k; empty = the study's own
  std::vector<double> average_records;  ///< of Light-Fit under a budget, 0 = none; empty = own
  int lights = 0;                       ///< test lights; 0 = 50, quick 16
  int training_lights = 200;
  bool train_shadows = false;
  int spp = 25;
  /// > 0: compare with an independent picture of so many samples; shadows, tradeoff: 0 = 256.
  int truth_spp = 0;
  int width = 0;  ///< pixels; 0 = the scene's
  int height = 0;
  int tile_stride = 0;     ///< measure every n-th tile; 0 = 1, quick: about 24 tiles
  int window = 0;          ///< shadows: pixels a side of what is measured; 0 = all, quick 96
  bool timed = false;      ///< times in the figures, where the study is not about them anyway
  bool pictures = false;   ///< shadows: write maps of visibility, side by side
  bool page_only = false;  ///< measure nothing, make NAME.html of an earlier run's documents
};

struct InfoOptions {
  std::string input;  ///< scene, cache or image
};

}  // namespace relume
