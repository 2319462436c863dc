// `relume convert`: deep EXR, which other programs flatten to the frame and which comes back in,
// and light rigs as UsdLux.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <regex>

#include "core/image/deep_io.h"
#include "core/image/image_io.h"
#include "core/scene/channel_map.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/oiiotool.h"
#include "tests/support/temporary_folder.h"
#include "viewer/aovs/aov_reader.h"
#include "viewer/commands/commands.h"
#include "viewer/frames/light_rig_usd.h"

namespace relume::test {
namespace {

const CommonOptions quiet{.quiet = true};

/// A built-in scene's records as a deep image, and the frame of the same records.
class Deep : public testing::TestWithParam<const char*> {
 protected:
  static PrepareOptions small() {
    PrepareOptions prepare;
    prepare.width = 44;
    prepare.height = 36;
    prepare.spp = 9;
    prepare.records = 3;
    return prepare;
  }

  void convert(const std::string& scene, const PrepareOptions& prepare) {
    silently([&] {
      run_convert({.input = scene, .output = deep_, .lights = {}, .prepare = prepare}, quiet);
    });
  }

  void render(const std::string& input, const PrepareOptions& prepare,
              const std::filesystem::path& output) {
    RenderOptions options;
    options.input = input;
    options.output = output;
    options.prepare = prepare;
    silently([&] { run_render(options, quiet); });
  }

  void prepare_from_deep(const std::string& proxy) {
    PrepareCommandOptions options;
    options.scene = deep_.string();
    options.output = cache_;
    options.channels = "relume";
    options.proxy = proxy;
    options.prepare.method = ReductionMethod::all;
    silently([&] { run_prepare(options, quiet); });
  }

  template <class Work>
  static void silently(const Work& work) {
    testing::internal::CaptureStdout();
    try {
      work();
    } catch (...) {
      testing::internal::GetCapturedStdout();
      throw;
    }
    testing::internal::GetCapturedStdout();
  }

  DeepImage read_all_channels() const {
    std::vector<std::string> names;
    for (const DeepChannel& channel : read_deep_header(deep_).channels)
      names.push_back(channel.name);
    return read_deep_image(deep_, names);
  }

  AovSamples read_samples() const {
    return {deep_, load_channel_map("relume", shader_table()), 1,
            load_scene("spheres", shader_table()).camera};
  }

  static size_t index_of(const DeepImage& image, const std::string& name) {
    for (size_t c = 0; c < image.channels.size(); ++c) {
      if (image.channels[c].name == name) return c;
    }
    ADD_FAILURE() << name;
    return 0;
  }

  static void drop_channel(DeepImage& image, const std::string& name) {
    const size_t dropped = index_of(image, name);
    std::vector<float> values;
    for (size_t i = 0; i < image.values.size(); ++i) {
      if (i % image.channels.size() != dropped) values.push_back(image.values[i]);
    }
    image.values = values;
    image.channels.erase(image.channels.begin() + static_cast<ptrdiff_t>(dropped));
  }

  TemporaryFolder folder_;
  std::filesystem::path deep_ = folder_.file("deep.exr");
  std::filesystem::path cache_ = folder_.file("back.relume");
};

/// Of the picture, by half floats; the kernels' own distance from double numbers is within it.
void expect_close(const Image& found, const Image& expected) {
  ASSERT_EQ(found.pixels.size(), expected.pixels.size());
  for (size_t i = 0; i < found.pixels.size(); ++i) {
    ASSERT_NEAR(found.pixels[i], expected.pixels[i], 0x1p-10 * expected.pixels[i] + 1e-6) << i;
  }
}

TEST_P(Deep, AFlattenOfAnotherProgramGivesTheFrame) {
  if (!has_oiiotool()) GTEST_SKIP() << "no oiiotool";
  for (const ReductionMethod method : {ReductionMethod::strong_kmeans, ReductionMethod::all}) {
    PrepareOptions prepare = small();
    prepare.method = method;
    convert(GetParam(), prepare);
    render(GetParam(), prepare, folder_.file("frame.exr"));
    const std::filesystem::path flat = folder_.file("flat.exr");
    ASSERT_TRUE(run_oiiotool(fmt::format("{} --flatten -o {}", deep_.string(), flat.string())));
    expect_close(read_image(flat), read_image(folder_.file("frame.exr")));
    const Image alpha = read_exr_channel(flat, "A");
    const Image coverage = read_exr_channel(folder_.file("frame.exr"), "A");
    for (size_t i = 0; i < alpha.pixels.size(); ++i) {
      ASSERT_NEAR(alpha.pixels[i], coverage.pixels[i], 0.5 / 255 + 0x1p-11) << i;
    }
  }
}

TEST_P(Deep, RecordsComeBackAsSamplesOfTheSamePicture) {
  convert(GetParam(), small());
  prepare_from_deep(GetParam());
  render(cache_.string(), {}, folder_.file("back.exr"));
  render(GetParam(), small(), folder_.file("frame.exr"));
  const Image back = read_image(folder_.file("back.exr"));
  const Image frame = read_image(folder_.file("frame.exr"));
  double sum = 0;
  double error = 0;
  for (size_t i = 0; i < frame.pixels.size(); ++i) {
    sum += frame.pixels[i];
    error += std::abs(double{back.pixels[i]} - frame.pixels[i]);
  }
  // Normals in half floats move highlights and which side of a surface faces a light.
  EXPECT_LT(error, 2e-3 * sum);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Deep, testing::Values("hair", "plants", "spheres"));

TEST_F(Deep, SamplesAreSortedAndWeightsSumToTheCoverage) {
  convert("plants", small());
  const DeepImage image = read_all_channels();
  const size_t weight = index_of(image, "weight.V");
  const size_t depth = index_of(image, "Z");
  const float* sample = image.values.data();
  size_t covered = 0;
  for (const uint32_t count : image.counts) {
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i, sample += image.channels.size()) {
      if (i > 0) {
        EXPECT_GE(sample[depth], (sample - image.channels.size())[depth]);
      }
      sum += sample[weight];
    }
    // Nine samples a pixel.
    EXPECT_NEAR(9 * sum, std::round(9 * sum), 1e-4);
    covered += count > 0 ? 1 : 0;
  }
  EXPECT_GT(covered, 500u);
}

TEST_F(Deep, TheSameRecordsGiveTheSameBytes) {
  convert("spheres", small());
  const std::string first = read_all(deep_);
  convert("spheres", small());
  EXPECT_TRUE(read_all(deep_) == first);
}

TEST_F(Deep, WithoutWeightsAlphasGiveThem) {
  convert("spheres", small());
  DeepImage image = read_all_channels();
  const AovSamples given = read_samples();
  prepare_from_deep("spheres");
  const RelightCache with_weights = RelightCache::open(cache_, shader_table());
  const std::vector<float> expected = with_weights.coverage();
  drop_channel(image, "weight.V");
  write_deep_exr(deep_, image);
  EXPECT_EQ(read_samples().sample_count(), given.sample_count());
  prepare_from_deep("spheres");
  const std::vector<float> found = RelightCache::open(cache_, shader_table()).coverage();
  for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1.01 / 255) << i;
}

TEST_F(Deep, BrokenFilesAreToldAndNotRead) {
  convert("spheres", small());
  const std::string whole = read_all(deep_);
  for (const double part : {0.02, 0.1, 0.3, 0.6, 0.95, 0.999}) {
    write_all(deep_,
              whole.substr(0, static_cast<size_t>(part * static_cast<double>(whole.size()))));
    EXPECT_ERROR(read_samples(), ErrorKind::input, "deep.exr");
  }
  write_all(deep_, "not an image");
  EXPECT_ERROR(read_samples(), ErrorKind::input, "deep.exr");
  EXPECT_ERROR(read_deep_image(folder_.file("nothing.exr"), {}), ErrorKind::input, "no such file");
  write_all(deep_, whole);
  EXPECT_ERROR(read_deep_image(deep_, std::vector<std::string>{"Q"}), ErrorKind::input,
               "no channel 'Q'");
  EXPECT_ERROR(read_image(deep_), ErrorKind::input, "deep");
}

TEST_F(Deep, ValuesThatCannotBeAreRefused) {
  convert("spheres", small());
  const DeepImage image = read_all_channels();
  const auto refuses = [&](const std::string& channel, float value, const std::string& part) {
    DeepImage changed = image;
    const size_t stride = changed.channels.size();
    const size_t at = index_of(changed, channel);
    for (size_t i = at; i < 50 * stride; i += stride) changed.values[i] = value;
    write_deep_exr(deep_, changed);
    EXPECT_ERROR(read_samples(), ErrorKind::input, part);
  };
  refuses("weight.V", 0.9f, "are not within [0, 1]");
  refuses("weight.V", -1, "are not within [0, 1]");
  refuses("weight.V", std::numeric_limits<float>::quiet_NaN(), "are not within [0, 1]");
  refuses("P.X", std::numeric_limits<float>::infinity(), "not finite");
  for (const char* needed : {"P.Y", "N.Z"}) {
    DeepImage changed = image;
    drop_channel(changed, needed);
    write_deep_exr(deep_, changed);
    EXPECT_ERROR(read_samples(), ErrorKind::input, "no channel or layer");
  }
  DeepImage crowded = image;
  const uint32_t first = crowded.counts[0];
  crowded.counts[0] = 1025;
  std::vector<float> more((1025 - first) * crowded.channels.size(), 0.0f);
  crowded.values.insert(crowded.values.begin(), more.begin(), more.end());
  write_deep_exr(deep_, crowded);
  EXPECT_ERROR(read_samples(), ErrorKind::limit, "1025 samples");
}

TEST_F(Deep, PackedCachesAndOtherFormatsAreRefused) {
  PrepareOptions prepare = small();
  prepare.format = CacheFormat::compact;
  EXPECT_ERROR(convert("spheres", prepare), ErrorKind::input, "--format exact");
  deep_ = folder_.file("deep.tif");
  EXPECT_ERROR(convert("spheres", small()), ErrorKind::usage, ".usda");
}

// The rig, read back.

std::vector<double> numbers_of(const std::string& text, const std::string& key) {
  const std::regex pattern(key + " = ([^\n]*)");
  std::smatch match;
  std::vector<double> numbers;
  if (!std::regex_search(text, match, pattern)) return numbers;
  const std::string line = match[1];
  const std::regex number("[-+]?[0-9.]+(e[-+]?[0-9]+)?");
  for (std::sregex_iterator i(line.begin(), line.end(), number), end; i != end; ++i) {
    numbers.push_back(std::stod(i->str()));
  }
  return numbers;
}

/// The text of a light's prim.
std::string prim_of(const std::string& rig, const std::string& name) {
  const size_t start = rig.find("\"" + name + "\" (");
  EXPECT_NE(start, std::string::npos) << name;
  return rig.substr(start, rig.find("\n    }\n", start) - start);
}

TEST(LightRig, SaysWhatTheLightsAre) {
  std::vector<Light> lights(3);
  lights[0] = {.name = "key 1",
               .type = LightType::spot,
               .position = {1, 2, 3},
               .direction = {0, -3, 4},
               .inner_angle_deg = 15,
               .outer_angle_deg = 20,
               .gain = 5};
  lights[1] = {.name = "key_1", .type = LightType::directional, .direction = {0, -2, 0}, .gain = 3};
  lights[2] = {.name = "9\"lamp",
               .position = {-1, 0, 1e-3f},
               .falloff = false,
               .color = {1, 0.5f, 0.25f},
               .gain = 2,
               .mute = true,
               .casts_shadow = false};
  const std::string rig = format_light_rig_usd(lights);
  EXPECT_EQ(rig.rfind("#usda 1.0\n", 0), 0u);
  EXPECT_EQ(std::count(rig.begin(), rig.end(), '{'), std::count(rig.begin(), rig.end(), '}'));
  EXPECT_EQ(std::count(rig.begin(), rig.end(), '('), std::count(rig.begin(), rig.end(), ')'));

  const std::string spot = prim_of(rig, "key_1");
  EXPECT_EQ(numbers_of(spot, "inputs:intensity"), std::vector<double>{20});
  EXPECT_EQ(numbers_of(spot, "cone:angle"), std::vector<double>{20});
  EXPECT_EQ(numbers_of(spot, "cone:softness"), std::vector<double>{0.25});
  const std::vector<double> m = numbers_of(spot, "xformOp:transform");
  ASSERT_EQ(m.size(), 16u);
  const dvec3 x(m[0], m[1], m[2]);
  const dvec3 y(m[4], m[5], m[6]);
  const dvec3 z(m[8], m[9], m[10]);
  EXPECT_NEAR(glm::distance(-z, dvec3(0, -0.6, 0.8)), 0, 1e-6);
  EXPECT_NEAR(glm::distance(glm::cross(x, y), z), 0, 1e-6);
  EXPECT_EQ(dvec3(m[12], m[13], m[14]), dvec3(1, 2, 3));

  const std::string sun = prim_of(rig, "key_1_2");
  EXPECT_NE(rig.find("DistantLight \"key_1_2\""), std::string::npos);
  EXPECT_EQ(numbers_of(sun, "inputs:intensity"), std::vector<double>{3});
  EXPECT_NEAR(numbers_of(sun, "xformOp:transform").at(9), 1, 1e-6);

  const std::string lamp = prim_of(rig, "_9_lamp");
  EXPECT_EQ(numbers_of(lamp, "inputs:color"), (std::vector<double>{1, 0.5, 0.25}));
  EXPECT_EQ(numbers_of(lamp, "inputs:shadow:enable"), std::vector<double>{0});
  EXPECT_NE(lamp.find("\"invisible\""), std::string::npos);
  EXPECT_NE(lamp.find("relume:name = \"9\\\"lamp\""), std::string::npos);
  EXPECT_EQ(numbers_of(lamp, "relume:falloff"), std::vector<double>{0});
}

TEST_F(Deep, RigsComeFromScenes) {
  deep_ = folder_.file("rig.usda");
  convert("hair", {});
  const std::string rig = read_all(deep_);
  for (const Light& light : load_scene("hair", shader_table()).lights) {
    EXPECT_EQ(numbers_of(prim_of(rig, light.name), "inputs:intensity"),
              std::vector<double>{static_cast<float>(4.0 * light.gain)});
  }
}

}  // namespace
}  // namespace relume::test
