#include <gtest/gtest.h>

#include <algorithm>

#include "core/scene/channel_map.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

TEST(ChannelMaps, EveryPresetPlacesItsSamples) {
  ASSERT_FALSE(channel_preset_names().empty());
  for (const std::string& name : channel_preset_names()) {
    const ChannelMap map = load_channel_map(name, shader_table());
    EXPECT_FALSE(map.types.empty()) << name;
    EXPECT_EQ(map.types.size() > 1, !map.id.empty()) << name << ": types are told apart";
    for (const ChannelType& type : map.types) {
      ASSERT_NE(type.shader, nullptr) << name;
      EXPECT_TRUE(std::ranges::any_of(type.fields, [](const ChannelSource& source) {
        return source.field == "position" && !source.layer.empty();
      })) << name;
    }
  }
}

TEST(ChannelMaps, ThatOfTheProgramKnowsEveryShader) {
  const ChannelMap map = load_channel_map("relume", shader_table());
  ASSERT_EQ(map.types.size(), shader_table().size());
  for (size_t i = 0; i < map.types.size(); ++i) {
    EXPECT_EQ(map.types[i].shader, shader_table()[i]);
    EXPECT_EQ(map.types[i].fields.size(), shader_table()[i]->fields.size());
    EXPECT_EQ(map.types[i].id, static_cast<float>(i + 1));
  }
}

TEST(ChannelMaps, FilesAreReadLikePresets) {
  const test::TemporaryFolder folder;
  const std::string file = folder.file("map.json").string();
  test::write_all(file, R"({"coverage": "A", "types": [{"shader": "lambert", "fields": {
      "position": "P", "normal": "N", "diffuse": [0.5, 0.25, 1]}}]})");
  const ChannelMap map = load_channel_map(file, shader_table());
  EXPECT_EQ(map.coverage, "A");
  ASSERT_EQ(map.types.size(), 1u);
  ASSERT_EQ(map.types[0].fields.size(), 3u);
  for (const ChannelSource& source : map.types[0].fields) {
    if (source.field == "position") {
      EXPECT_EQ(source.layer, "P");
    } else if (source.field == "diffuse") {
      EXPECT_EQ(source.constant, vec3(0.5f, 0.25f, 1));
    }
  }
  EXPECT_FALSE(map.types[0].id.has_value());
  EXPECT_ERROR(load_channel_map("cycle", shader_table()), ErrorKind::input, "cycle");
}

}  // namespace
}  // namespace relume
