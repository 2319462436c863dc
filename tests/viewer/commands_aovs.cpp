// Another renderer's samples: `relume sample` writes such an image, `relume prepare --channels`
// takes it, and the pictures are those of the scene itself.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/image/image_io.h"
#include "core/scene/channel_map.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/oiiotool.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"
#include "viewer/aovs/aov_reader.h"
#include "viewer/aovs/aov_strips.h"
#include "viewer/aovs/aov_writer.h"
#include "viewer/commands/commands.h"

namespace relume::test {
namespace {

constexpr int side = 3;
constexpr int width = 36;
constexpr int height = 28;

/// The AOVs of a built-in scene, changed at will, and what comes of reading them.
class Aovs : public testing::Test {
 protected:
  explicit Aovs(const std::string& name = "plants")
      : scene_(load_scene(name, shader_table())),
        tracer_(scene_),
        view_(make_view_sampler(scene_, tracer_, width, height, side * side, 5)) {
    write_aovs(view_, side, file_, {});
    for (const std::string& channel : read_channel_names(file_)) {
      channels_.emplace_back(channel, read_exr_channel(file_, channel));
    }
  }

  Image& channel(const std::string& name) {
    for (auto& [channel, image] : channels_) {
      if (channel == name) return image;
    }
    ADD_FAILURE() << name;
    return channels_.front().second;
  }

  void write() {
    std::vector<ExrLayer> layers;
    for (const auto& [name, image] : channels_) layers.push_back({"", {name}, &image});
    write_exr(file_, layers);
  }

  AovSamples read(const std::string& map = "relume", int samples = side) {
    return {file_, load_channel_map(map, shader_table()), samples, scene_.camera};
  }

  std::string write_map(const std::string& text) {
    write_all(folder_.file("map.json"), text);
    return folder_.file("map.json").string();
  }

  /// What is sampled from `source`, or from the scene.
  RelightCache prepare(const AovSamples* samples, ReductionMethod method) {
    Scene scene = scene_;
    if (samples) samples->add_materials(scene);
    const Tracer tracer(scene);
    PrepareParams params;
    params.spp = side * side;
    params.width = width;
    params.height = height;
    params.reduction.method = method;
    params.reduction.records = 4;
    params.reduction.seed = 5;
    SampleSource source;
    if (samples) source = samples->source();
    if (samples) params.source = &source;
    return prepare_in_memory(scene, tracer, params, {});
  }

  /// The picture of the same under traced shadows.
  Image picture(const AovSamples* samples, ReductionMethod method) {
    const RelightCache cache = prepare(samples, method);
    const auto shadows = make_shadow(ShadowMethod::ray, tracer_, cache);
    return render_frame(cache, scene_.lights, shadows.get());
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.file("aovs.exr");
  Scene scene_;
  Tracer tracer_;
  ViewSampler view_;
  std::vector<std::pair<std::string, Image>> channels_;
};

class HairAovs : public Aovs {
 protected:
  HairAovs() : Aovs("hair") {}
};

/// A scene of glTF materials.
class GgxAovs : public Aovs {
 protected:
  GgxAovs() : Aovs(RELUME_SOURCE_DIR "/scenes/blender/example/ball.json") {}
};

TEST(ChannelPresets, RelumesNamesEveryFieldOfEveryShader) {
  const ChannelMap map = load_channel_map("relume", shader_table());
  ASSERT_EQ(map.types.size(), shader_table().size());
  for (size_t i = 0; i < map.types.size(); ++i) {
    EXPECT_EQ(map.types[i].shader, shader_table()[i]);
    EXPECT_EQ(map.types[i].id, static_cast<float>(i + 1));
    EXPECT_EQ(map.types[i].fields.size(), shader_table()[i]->fields.size());
  }
}

TEST_F(GgxAovs, GiveThePictureThatTheSceneGives) {
  const AovSamples samples = read();
  EXPECT_EQ(picture(nullptr, ReductionMethod::all).pixels,
            picture(&samples, ReductionMethod::all).pixels);
}

TEST_F(Aovs, GiveThePictureThatTheSceneGives) {
  const AovSamples samples = read();
  for (const ReductionMethod method : {ReductionMethod::all, ReductionMethod::strong_kmeans}) {
    const Image direct = picture(nullptr, method);
    const Image imported = picture(&samples, method);
    ASSERT_GT(max_difference(direct, Image(width, height)), 0.01f);
    EXPECT_EQ(direct.pixels, imported.pixels);
  }
}

TEST_F(HairAovs, GiveThePictureThatTheSceneGives) {
  const AovSamples samples = read();
  EXPECT_EQ(picture(nullptr, ReductionMethod::all).pixels,
            picture(&samples, ReductionMethod::all).pixels);
}

TEST_F(Aovs, GiveTheSameBytesWhateverStaysInMemory) {
  const ChannelMap map = load_channel_map("relume", shader_table());
  const AovSamples all(file_, map, side, scene_.camera);
  const AovSamples nothing(file_, map, side, scene_.camera, 0);
  const RelightCache expected = prepare(&all, ReductionMethod::strong_kmeans);
  const RelightCache found = prepare(&nothing, ReductionMethod::strong_kmeans);
  EXPECT_TRUE(std::ranges::equal(found.bytes(), expected.bytes()));
}

TEST_F(Aovs, KeepNoMoreStripsThanTheyMay) {
  const std::vector<std::string> names = {"P.X", "P.Y", "P.Z"};
  const auto open = [&](uint64_t kept_bytes) {
    ExrRows file(file_);
    file.choose(names);
    return std::make_unique<AovStrips>(file_, std::move(file), side, names.size(),
                                       AovStrips::Weighing::even, kept_bytes);
  };
  const auto strips = open(0);
  const std::weak_ptr<const AovStrip> first = strips->strip(0);
  EXPECT_FALSE(first.expired());
  const uint64_t bytes = first.lock()->bytes();
  EXPECT_EQ(bytes, sizeof(float) * 3 * side * side * width * tile_size);
  strips->strip(1);
  EXPECT_TRUE(first.expired());
  const auto enough = open(2 * bytes);
  const std::weak_ptr<const AovStrip> kept = enough->strip(0);
  enough->strip(1);
  EXPECT_EQ(kept.lock(), enough->strip(0));
}

TEST_F(Aovs, AnImageOfTheSamplesTilesHoldsThem) {
  uint64_t hits = 0;
  for (int i = 0; i < tile_count(view_); ++i) hits += sample_tile(view_, i).row_count();
  const AovSamples samples = read();
  EXPECT_EQ(samples.sample_count(), hits);
  EXPECT_EQ(samples.width(), width);
  EXPECT_EQ(samples.height(), height);
}

TEST_F(Aovs, AreSoughtWhereTheFileHoldsPixels) {
  if (!has_oiiotool()) GTEST_SKIP() << "no oiiotool";
  const auto change = [&](const std::string& options) {
    const std::string out = folder_.file("changed.exr").string();
    ASSERT_TRUE(run_oiiotool(fmt::format("{} {} -o {}", file_.string(), options, out)));
    std::filesystem::rename(out, file_);
  };
  const auto is_inside = [](int x, int y) { return x >= 7 && x < 27 && y >= 4 && y < 20; };
  uint64_t hits = 0;
  for (int i = 0; i < tile_count(view_); ++i) {
    const SampleTile tile = sample_tile(view_, i);
    for (const TypedRows& rows : tile.types) {
      for (int p = 0; p < tile.pixel_count(); ++p) {
        if (!is_inside(tile.x0 + p % tile.width, tile.y0 + p / tile.width)) continue;
        hits += rows.first[p + 1] - rows.first[p];
      }
    }
  }
  change("--crop 60x48+21+12");
  const AovSamples samples = read();
  EXPECT_EQ(samples.sample_count(), hits);
  EXPECT_EQ(samples.width(), width);
  const Image cropped = picture(&samples, ReductionMethod::all);
  const Image whole = picture(nullptr, ReductionMethod::all);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(cropped.at(x, y)[c], is_inside(x, y) ? whole.at(x, y)[c] : 0) << x << ", " << y;
      }
    }
  }
  change("--fullsize 60000x60000+0+0");
  EXPECT_ERROR(read(), ErrorKind::limit, "20000 x 20000 pixels");
}

TEST_F(Aovs, RefusesFilteredImages) {
  Image& x = channel("N.X");
  for (size_t i = 0; i + 1 < x.pixel_count(); ++i) {
    x.pixels[i] = 0.5f * (x.pixels[i] + x.pixels[i + 1]);
  }
  write();
  EXPECT_ERROR(read(), ErrorKind::input, "the image was filtered");
}

TEST_F(Aovs, RefusesPartialCoverage) {
  channels_.emplace_back("A", channel("id.V"));
  for (float& value : channels_.back().second.pixels) value = value > 0 ? 0.75f : 0.0f;
  write();
  const std::string map = write_map(R"({"coverage": "A", "types": [{"shader": "lambert",
      "fields": {"position": "P", "normal": "N", "diffuse": "diffuse"}}]})");
  EXPECT_ERROR(read(map), ErrorKind::input, "covered in part");
}

TEST_F(Aovs, RefusesWhatIsNotWhereTheCameraSeesIt) {
  for (float& value : channel("P.X").pixels) value += 0.3f * tracer_.bounds().radius();
  write();
  EXPECT_ERROR(read(), ErrorKind::input, "proxy's camera");
}

TEST_F(Aovs, RefusesWhatDoesNotFit) {
  EXPECT_ERROR(read("relume", 5), ErrorKind::input, "blocks of 5 x 5");
  EXPECT_ERROR(read("cycles"), ErrorKind::input, "Combined.A");
  EXPECT_ERROR(read(folder_.file("absent.json").string()), ErrorKind::input, "absent.json");
  const Image& id = channel("id.V");
  size_t hit = 0;
  while (!(id.pixels[hit] > 0)) ++hit;
  channel("diffuse.G").pixels[hit] = std::numeric_limits<float>::quiet_NaN();
  write();
  EXPECT_ERROR(read(), ErrorKind::input, "diffuse of sub-pixel");
  std::fill(channel("id.V").pixels.begin(), channel("id.V").pixels.end(), 0.0f);
  write();
  EXPECT_ERROR(read(), ErrorKind::input, "no sub-pixel holds a sample");
}

TEST_F(Aovs, RefusesMapsThatMakeNoSense) {
  const auto refuse = [&](const std::string& text, const std::string& part) {
    const std::string map = write_map(text);
    EXPECT_ERROR(load_channel_map(map, shader_table()), ErrorKind::input, part);
  };
  refuse("{}", "types");
  refuse(R"({"types": []})", "at least one");
  refuse(R"({"types": [{"shader": "glass", "fields": {}}]})", "glass");
  refuse(R"({"types": [{"shader": "lambert", "fields": {"position": "P"}}]})", "normal");
  refuse(R"({"types": [{"shader": "lambert", "fields": {"position": "P", "normal": 1}}]})",
         "/types/0/fields/normal");
  refuse(R"({"types": [{"shader": "lambert", "fields": {"position": "P", "normal": "N",
             "tangent": "T"}}]})",
         "no such field");
  const std::string type = R"({"shader": "lambert", "fields": {"position": "P", "normal": "N"}})";
  refuse("{\"types\": [" + type + ", " + type + "]}", "several types");
}

TEST_F(Aovs, PresetsOfOtherRenderersFindTheirNames) {
  const std::vector<std::pair<std::string, std::array<std::string, 4>>> names = {
      {"cycles",
       {"ViewLayer.Position.X", "ViewLayer.Normal.X", "ViewLayer.DiffCol.R",
        "ViewLayer.Combined.A"}},
      {"arnold", {"P.X", "N.X", "diffuse_albedo.R", "A"}},
      {"renderman", {"__Pworld.r", "__Nworld.r", "albedo.r", "a"}}};
  std::map<std::string, Image> images(channels_.begin(), channels_.end());
  const uint64_t hits = read().sample_count();
  for (const auto& [preset, channels] : names) {
    channels_.clear();
    const std::array<std::string, 3> ours{"P.X", "N.X", "diffuse.R"};
    for (size_t i = 0; i < 3; ++i) {
      const auto next = [](std::string name, int c) {
        const std::string letters = name.back() == 'X' ? "XYZ" : name.back() == 'R' ? "RGB" : "rgb";
        name.back() = letters[static_cast<size_t>(c)];
        return name;
      };
      for (int c = 0; c < 3; ++c) {
        channels_.emplace_back(next(channels[i], c), images.at(next(ours[i], c)));
      }
    }
    channels_.emplace_back(channels[3], images.at("id.V"));
    for (float& value : channels_.back().second.pixels) value = value > 0 ? 1.0f : 0.0f;
    write();
    EXPECT_EQ(read(preset).sample_count(), hits) << preset;
  }
}

}  // namespace
}  // namespace relume::test
