// The program as a user runs it: exit codes, one-line errors, files written.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/image/heatmap.h"
#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "core/math/color.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace relume::test {
namespace {

struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs `relume ARGUMENTS` in a shell, in `folder`.
Outcome run_relume(const TemporaryFolder& folder, const std::string& arguments) {
  const std::string out = folder.file("stdout.txt").string();
  const std::string err = folder.file("stderr.txt").string();
  const std::string command = "cd '" + folder.path().string() + "' && '" + RELUME_PROGRAM + "' " +
                              arguments + " >'" + out + "' 2>'" + err + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_all(out), read_all(err)};
}

/// One figure of the program's "name value" lines.
double figure(const Outcome& outcome, const std::string& name) {
  const size_t at = ("\n" + outcome.out).find("\n" + name + " ");
  if (at == std::string::npos) {
    ADD_FAILURE() << "no " << name << " in: " << outcome.out;
    return 0;
  }
  return std::stod(outcome.out.substr(at + name.size()));
}

void expect_one_line_error(const Outcome& outcome, int exit_code, const std::string& part) {
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
}

/// A scene of one file, next to it.
std::string scene_with(const std::string& geometry, const std::string& material) {
  return R"({"name": "t", "image": {"width": 32, "height": 32},
    "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov_y_deg": 40},
    "materials": [)" +
         material + R"(], "geometry": [)" + geometry + R"(],
    "lights": [{"name": "key", "type": "point", "position": [1, 2, 3], "gain": 20}]})";
}

const char* const plain_material = R"({"name": "grey", "shader": "lambert"})";
const char* const small = "-q --width 48 --height 48 --spp 9 ";

TEST(Program, RefusesUnknownCommandsWithTwo) {
  const TemporaryFolder folder;
  expect_one_line_error(run_relume(folder, "frobnicate"), 2,
                        "\"frobnicate\" is no command; there are demo, view,");
  const Outcome hostile = run_relume(folder, "\"$(printf 'frob\\033[2Jnicate\\007')\"");
  EXPECT_EQ(hostile.exit_code, 2);
  EXPECT_NE(hostile.err.find("nicate"), std::string::npos) << hostile.err;
  EXPECT_EQ(hostile.err.find_first_of("\033\007"), std::string::npos) << hostile.err;
  EXPECT_EQ(run_relume(folder, "render hair").exit_code, 2);
  EXPECT_EQ(run_relume(folder, "render hair -o x.exr --method nonsense").exit_code, 2);
  EXPECT_EQ(run_relume(folder, "--help").exit_code, 0);
}

TEST(Program, NamesFileAndFieldOfABadScene) {
  const TemporaryFolder folder;
  write_all(
      folder.file("bad.json"),
      scene_with(R"({"generator": "sphere", "radius": -1, "material": "grey"})", plain_material));
  expect_one_line_error(run_relume(folder, "render bad.json -q -o f.exr"), 3, "/geometry/0/radius");
  write_all(folder.file("cut.json"), R"({"name": "t", "image": {"width")");
  expect_one_line_error(run_relume(folder, "render cut.json -q -o f.exr"), 3, "cut.json");
  expect_one_line_error(run_relume(folder, "render absent.json -q -o f.exr"), 3, "absent.json");
  EXPECT_FALSE(std::filesystem::exists(folder.file("f.exr")));
}

TEST(Program, RefusesATruncatedObj) {
  const TemporaryFolder folder;
  write_all(folder.file("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2");
  write_all(folder.file("s.json"),
            scene_with(R"({"file": "t.obj", "material": "grey"})", plain_material));
  expect_one_line_error(run_relume(folder, "render s.json -q -o f.exr"), 3, "t.obj");
}

TEST(Program, RefusesATruncatedHairFile) {
  const TemporaryFolder folder;
  std::string header(128, '\0');
  header.replace(0, 4, "HAIR");
  header[4] = 9;   // strands that the file does not hold
  header[8] = 90;  // points
  header[12] = 2;  // arrays: points
  write_all(folder.file("t.hair"), header + "short");
  write_all(folder.file("s.json"), scene_with(R"({"file": "t.hair", "material": "h"})",
                                              R"({"name": "h", "shader": "kajiya-kay"})"));
  expect_one_line_error(run_relume(folder, "render s.json -q -o f.exr"), 3, "t.hair");
}

TEST(Program, RefusesATruncatedTexture) {
  const TemporaryFolder folder;
  DisplayImage image{64, 64, 3, std::vector<uint8_t>(64 * 64 * 3, 100)};
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<uint8_t>(i * 37);
  write_png(folder.file("t.png"), image);
  const std::string whole = read_all(folder.file("t.png"));
  write_all(folder.file("t.png"), whole.substr(0, whole.size() / 2));
  write_all(
      folder.file("s.json"),
      scene_with(R"({"generator": "sphere", "material": "grey"})",
                 R"({"name": "grey", "shader": "lambert", "diffuse": {"texture": "t.png"}})"));
  expect_one_line_error(run_relume(folder, "render s.json -q -o f.exr"), 3, "t.png");
}

TEST(Program, RefusesATruncatedCache) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_relume(folder, std::string("prepare spheres -o c.relume ") + small).exit_code, 0);
  const std::string whole = read_all(folder.file("c.relume"));
  write_all(folder.file("c.relume"), whole.substr(0, whole.size() - 7));
  expect_one_line_error(run_relume(folder, "render c.relume -q -o f.exr"), 3, "c.relume");
}

TEST(Program, ReportsAnUnwritableOutputWithFive) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run_relume(folder, std::string("render spheres -o absent/f.exr ") + small);
  expect_one_line_error(outcome, 5, "absent/f.exr");
}

TEST(Program, RendersTheSameFromSceneAndCacheForAnyThreadCount) {
  const TemporaryFolder folder;
  const std::string options = small;
  ASSERT_EQ(run_relume(folder, "prepare hair -o c.relume " + options).exit_code, 0);
  ASSERT_EQ(run_relume(folder, "render c.relume -q -o cache.exr --threads 1").exit_code, 0);
  ASSERT_EQ(run_relume(folder, "render hair -o scene.exr --threads 3 " + options).exit_code, 0);
  EXPECT_EQ(read_image(folder.file("cache.exr")).pixels,
            read_image(folder.file("scene.exr")).pixels);
}

TEST(Program, ComparesKmeansWithAllSamples) {
  const TemporaryFolder folder;
  const std::string size = "-q --width 64 --height 64 ";
  ASSERT_EQ(run_relume(folder, "render hair --reference -o all.exr " + size).exit_code, 0);
  ASSERT_EQ(run_relume(folder, "render hair --method kmeans -o k8.exr " + size).exit_code, 0);
  const Outcome same = run_relume(folder, "compare all.exr all.exr --fail 0");
  EXPECT_EQ(same.exit_code, 0);
  EXPECT_EQ(figure(same, "error_image"), 0);
  const Outcome reduced = run_relume(folder, "compare k8.exr all.exr --heatmap h.png --fail 1e-9");
  EXPECT_EQ(reduced.exit_code, 1);
  EXPECT_GT(figure(reduced, "error_image"), 0);
  EXPECT_LT(figure(reduced, "error"), 0.5 * figure(reduced, "reference_mean"));
  EXPECT_TRUE(std::filesystem::exists(folder.file("h.png")));
}

TEST(Program, LightLayersSumToBeauty) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_relume(folder, std::string("render hair -o f.exr ") + small).exit_code, 0);
  const Image beauty = read_image(folder.file("f.exr"));
  const Image key = read_exr_layer(folder.file("f.exr"), "light.key.");
  const Image rim = read_exr_layer(folder.file("f.exr"), "light.rim.");
  for (size_t i = 0; i < beauty.pixels.size(); ++i) {
    ASSERT_NEAR(beauty.pixels[i], key.pixels[i] + rim.pixels[i], 1e-6 + 1e-6 * beauty.pixels[i]);
  }
}

/// A cache of random records, 40 x 24 pixels, with or without predicted errors.
RelightCache write_random_cache(const std::filesystem::path& path, bool predicted) {
  const std::vector<SampleType> types = all_sample_types();
  std::vector<SampleTile> tiles = make_random_tiles(types, 40, 24, 2);
  CacheWriter writer(path);
  for (SampleTile& tile : tiles) {
    if (predicted) fill_predicted_error(tile);
    writer.add(pack_tile(tile, types));
  }
  CacheInfo info = make_tile_info(tiles[0], types, {0, 0, 5});
  info.width = 40;
  info.height = 24;
  info.records = 4;
  info.average_records = 3.5f;
  info.lights = {make_point_light({1, 2, 3}, 20)};
  writer.finish(info);
  return RelightCache::open(path, shader_table());
}

std::vector<float> read_map(const std::filesystem::path& path, const std::string& channel) {
  return read_exr_channel(path, channel).pixels;
}

TEST(Program, ExrAndPngCarryPredictedErrorAndRecords) {
  const TemporaryFolder folder;
  const RelightCache cache = write_random_cache(folder.file("c.relume"), true);
  const Outcome outcome = run_relume(folder,
                                     "render c.relume -q --shadow none -o f.exr "
                                     "--predicted-error p.png --record-map r.png");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(read_map(folder.file("f.exr"), "predicted_error.V"), cache.predicted_error());
  EXPECT_EQ(read_map(folder.file("f.exr"), "records.V"), cache.record_counts());

  // Values of the picture part, as the scale's colours say.
  const Image predicted = read_image(folder.file("p.png"));
  const Image records = read_image(folder.file("r.png"));
  const float top = 0.2f;  // the largest is 0.001 (1 + 39 + 3 * 23)
  for (const auto& [image, values, range] : {std::tuple(predicted, cache.predicted_error(), top),
                                             std::tuple(records, cache.record_counts(), 16.0f)}) {
    EXPECT_GT(image.height, 24) << "no scale";
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 40; ++x) {
        const vec3 color = heat_color(values[y * 40 + x] / range);
        const float* pixel = image.at(x, y);
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR(pixel[c], linear_from_srgb(color[c]), 0.02f) << x << ' ' << y;
        }
      }
    }
  }
}

TEST(Program, SaysThatACacheHasNoPredictedError) {
  const TemporaryFolder folder;
  write_random_cache(folder.file("c.relume"), false);
  expect_one_line_error(
      run_relume(folder, "render c.relume -q --shadow none -o f.exr --predicted-error p.png"), 2,
      "predicted no errors");
  EXPECT_FALSE(std::filesystem::exists(folder.file("p.png")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("f.exr")));
  ASSERT_EQ(run_relume(folder, "render c.relume -q --shadow none -o f.exr").exit_code, 0);
  const std::vector<std::string> names = read_channel_names(folder.file("f.exr"));
  EXPECT_EQ(std::count(names.begin(), names.end(), "records.V"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "predicted_error.V"), 0);
}

TEST(Program, InfoPrintsMeansOverCoveredPixelsAndTheBudget) {
  const TemporaryFolder folder;
  const RelightCache cache = write_random_cache(folder.file("c.relume"), true);
  const Outcome outcome = run_relume(folder, "info c.relume");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  double error = 0;
  double pixels = 0;
  for (size_t i = 0; i < cache.coverage().size(); ++i) {
    if (cache.coverage()[i] == 0) continue;
    error += cache.predicted_error()[i];
    ++pixels;
  }
  ASSERT_LT(pixels, 40 * 24);
  EXPECT_NEAR(figure(outcome, "predicted_error"), error / pixels, 1e-5 * error / pixels);
  EXPECT_NEAR(figure(outcome, "records_per_pixel"),
              static_cast<double>(cache.info().record_count) / pixels, 1e-4);
  EXPECT_EQ(figure(outcome, "budget_records"), 3.5);
  EXPECT_EQ(figure(outcome, "budget_error"), 0);
  write_random_cache(folder.file("c.relume"), false);
  EXPECT_EQ(run_relume(folder, "info c.relume").out.find("predicted_error"), std::string::npos);
}

TEST(Program, PrepareKeepsAnAverageAndStoresPredictedErrors) {
  const TemporaryFolder folder;
  const std::string size = "-q --width 36 --height 36 --spp 16 ";
  for (const char* method : {"strong-kmeans", "light-fit"}) {
    const Outcome prepared = run_relume(
        folder, "prepare hair -o c.relume --average-records 3 --method " + (method + (" " + size)));
    ASSERT_EQ(prepared.exit_code, 0) << prepared.err;
    const Outcome info = run_relume(folder, "info c.relume");
    EXPECT_NEAR(figure(info, "records_per_pixel"), 3, 0.15) << method;
    EXPECT_EQ(figure(info, "budget_records"), 3);
    EXPECT_EQ(figure(info, "records"), 16) << "the most that a pixel may have";
    EXPECT_GT(figure(info, "predicted_error"), 0);
    const RelightCache cache = RelightCache::open(folder.file("c.relume"), shader_table());
    EXPECT_EQ(cache.predicted_error().size(), 36u * 36);
  }
}

TEST(Program, ATargetErrorTakesAsFewRecordsAsItNeeds) {
  const TemporaryFolder folder;
  const std::string size = "-q --width 56 --height 56 --spp 16 ";
  double records = 0;
  double error = 1e30;
  for (const char* target : {"0.2", "0.05"}) {
    const Outcome prepared =
        run_relume(folder, "prepare hair -o c.relume --target-error " + (target + (" " + size)));
    ASSERT_EQ(prepared.exit_code, 0) << prepared.err;
    const Outcome info = run_relume(folder, "info c.relume");
    EXPECT_NEAR(figure(info, "budget_error"), std::stod(target), 1e-6);
    EXPECT_GT(figure(info, "records_per_pixel"), 1.5 * records);
    EXPECT_LT(figure(info, "predicted_error"), 0.5 * error);
    records = figure(info, "records_per_pixel");
    error = figure(info, "predicted_error");
  }
}

TEST(Program, RefusesBudgetsThatCannotBe) {
  const TemporaryFolder folder;
  const std::string prepare = "prepare spheres -q -o c.relume ";
  expect_one_line_error(run_relume(folder, prepare + "--average-records 3 --target-error 0.1"), 2,
                        "exclude each other");
  expect_one_line_error(run_relume(folder, prepare + "--method all --average-records 3"), 2,
                        "does not reduce");
  expect_one_line_error(run_relume(folder, prepare + "--method pure --predict-error"), 2,
                        "does not reduce");
  EXPECT_EQ(run_relume(folder, prepare + "--average-records 0").exit_code, 2);
  EXPECT_EQ(run_relume(folder, prepare + "--average-records 65").exit_code, 2);
  EXPECT_EQ(run_relume(folder, prepare + "--target-error 1.5").exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder.file("c.relume")));
}

TEST(Program, BenchSetsSeveralCachesBesideTheFirst) {
  const TemporaryFolder folder;
  const std::string prepare = "prepare spheres " + std::string(small) + "--method kmeans ";
  ASSERT_EQ(run_relume(folder, prepare + "--records 4 -o a.relume").exit_code, 0);
  ASSERT_EQ(run_relume(folder, prepare + "--records 1 -o b.relume").exit_code, 0);
  const Outcome outcome = run_relume(folder, "bench a.relume b.relume --repeats 1 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::vector<std::string> names;
  const nlohmann::json figures = nlohmann::json::parse(outcome.out);
  for (const auto& row : figures["rows"]) {
    names.push_back(row["name"]);
    if (names.back() == "a") {
      EXPECT_EQ(row["ratio"], 1);
    }
  }
  EXPECT_EQ(names, (std::vector<std::string>{"a", "b", "a-4-lights", "b-4-lights", "memory-a",
                                             "memory-b"}));
}

TEST(Program, BenchRefusesSizesThatAreNone) {
  const TemporaryFolder folder;
  for (const char* size : {"12", "0x5", "640x480x3", "99999x9"}) {
    const Outcome outcome = run_relume(folder, std::string("bench spheres --size ") + size);
    EXPECT_EQ(outcome.exit_code, 2) << size;
    EXPECT_NE(outcome.err.find("WIDTHxHEIGHT"), std::string::npos) << outcome.err;
  }
}

TEST(Program, StudyMeasuresMethodsAgainstKmeans) {
  const TemporaryFolder folder;
  const Outcome outcome = run_relume(folder,
                                     "study methods spheres -q --quick --methods kmeans light-fit "
                                     "--shadows none --records 2 --average-records 0 --width 64 "
                                     "--height 64 "
                                     "--spp 16 --json --output out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto document = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(document["schema"], "relume-study-methods-1");
  const auto& rows = document["rows"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["method"], "kmeans");
  EXPECT_EQ(rows[1]["method"], "light-fit");
  for (const auto& row : rows) {
    EXPECT_EQ(row["scene"], "spheres");
    EXPECT_EQ(row["records"], 2);
    EXPECT_EQ(row["lights"], 16) << "a quick study's";
    EXPECT_GT(row["covered_pixels"], 1000);
    EXPECT_GT(row["error"], 0);
    EXPECT_LT(row["error_image"], row["error"]) << "the background has no error";
    EXPECT_NEAR(row["error_relative"].get<double>(),
                row["error"].get<double>() / row["reference_mean"].get<double>(), 1e-9);
    EXPECT_LE(row["average_records"], 2);
    EXPECT_NEAR(row["ratio_to_kmeans"].get<double>(),
                row["error"].get<double>() / rows[0]["error"].get<double>(), 1e-9);
  }
  EXPECT_EQ(rows[0]["ratio_to_kmeans"], 1);
  EXPECT_LT(rows[1]["ratio_to_kmeans"], 0.8);
  EXPECT_EQ(rows[0]["predicted_error"], 0);
  EXPECT_GT(rows[1]["predicted_error"], 0);

  EXPECT_EQ(nlohmann::json::parse(read_all(folder.file("out") / "methods.json")), document);
  const std::string csv = read_all(folder.file("out") / "methods.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3) << "a head and two rows";
}

TEST(Program, StudyOfABudgetIsHeldAgainstEightRecords) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run_relume(folder,
                 "study methods spheres -q --methods kmeans light-fit "
                 "--shadows none --records 8 --average-records 2 --lights 4 --width 32 "
                 "--height 32 --spp 16 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto rows = nlohmann::json::parse(outcome.out)["rows"];
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[2]["budget"], 2);
  EXPECT_EQ(rows[2]["lights"], 4);
  EXPECT_LE(rows[2]["average_records"], 2);
  EXPECT_GT(rows[2]["average_records"], 1.8);
  EXPECT_NEAR(rows[2]["ratio_to_kmeans"].get<double>(),
              rows[2]["error"].get<double>() / rows[0]["error"].get<double>(), 1e-9);
}

TEST(Program, StudyOfPicturesWritesThemWithTheirErrors) {
  const TemporaryFolder folder;
  const Outcome outcome = run_relume(folder,
                                     "study smooth spheres -q --methods pure kmeans --records 2 "
                                     "--width 32 --height 32 --spp 9 --json -o out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto document = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(document["schema"], "relume-study-smooth-1");
  ASSERT_EQ(document["rows"].size(), 4u) << "two methods, with shadows and without";
  for (const auto& row : document["rows"]) EXPECT_GT(row["error"], 0);
  EXPECT_GT(document["rows"][0]["error"], document["rows"][2]["error"]) << "pure against kmeans";
  const auto& pictures = document["pictures"];
  ASSERT_EQ(pictures.size(), 10u) << "three pictures and two maps of errors, twice";
  for (const auto& picture : pictures) {
    const Image image = read_image(folder.file("out") / picture["file"].get<std::string>());
    EXPECT_EQ(image.width, picture["width"]);
    EXPECT_EQ(image.height, picture["height"]);
  }
  EXPECT_GT(read_all(folder.file("out") / "smooth.html").size(), 1000000u);
}

TEST(Program, StudyMeasuresShadowsAgainstTheTruth) {
  const TemporaryFolder folder;
  const Outcome outcome = run_relume(folder,
                                     "study shadows spheres -q --methods kmeans --records 4 2 "
                                     "--shadows none ray --width 96 --height 64 --window 32 "
                                     "--truth-spp 36 --timed --pictures --json --output out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto document = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(document["schema"], "relume-study-shadows-1");
  const auto& rows = document["rows"];
  ASSERT_EQ(rows.size(), 5u * 6) << "the reference and four trials, each five lights and a mean";
  EXPECT_EQ(rows[0]["method"], "all") << "the reference comes first";
  EXPECT_EQ(rows[0]["ratio_to_all"], 1);
  double unshadowed = 0;
  for (size_t first = 0; first < rows.size(); first += 6) {
    double mae = 0;
    for (size_t i = first; i < first + 5; ++i) {
      EXPECT_GE(rows[i]["mae"], 0);
      EXPECT_LE(rows[i]["bias"], rows[i]["mae"].get<double>() * 1.5);
      mae += rows[i]["mae"].get<double>() / 5;
    }
    EXPECT_EQ(rows[first + 5]["light"], "mean");
    EXPECT_NEAR(rows[first + 5]["mae"].get<double>(), mae, 1e-9);
    const bool is_traced = rows[first]["shadow"] == "ray";
    EXPECT_EQ(rows[first]["ms_move"] > 0, is_traced);
    EXPECT_EQ(rows[first]["structure_bytes"] > 0, is_traced);
    // Trials without shadows come before those with them.
    if (!is_traced) unshadowed = mae;
    if (is_traced && first > 0) {
      EXPECT_LT(mae, 0.5 * unshadowed) << rows[first]["method"] << " " << rows[first]["records"];
    }
  }
  EXPECT_EQ(nlohmann::json::parse(read_all(folder.file("out") / "shadows.json")), document);
  EXPECT_TRUE(std::filesystem::exists(folder.file("out") / "shadows-spheres.png"));
}

TEST(Program, StudyRefusesUnknownNamesWithTwo) {
  const TemporaryFolder folder;
  const Outcome outcome = run_relume(folder, "study methods spheres -q --methods kmeans nonsense");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("'nonsense' is not one of"), std::string::npos) << outcome.err;
  EXPECT_EQ(run_relume(folder, "study shadows spheres -q --shadows nonsense").exit_code, 2);
  EXPECT_EQ(run_relume(folder, "study nonsense").exit_code, 2);
  EXPECT_EQ(run_relume(folder, "study").exit_code, 2);
}

TEST(Program, DemoWritesItsPicturesWithoutADisplay) {
  const TemporaryFolder folder;
  const Outcome outcome = run_relume(folder, std::string("demo --offscreen out ") + small);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* name :
       {"frame.png", "frame.exr", "reference.png", "heatmap.png", "before.png", "after.png"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.file("out") / name)) << name;
  }
  EXPECT_NE(read_all(folder.file("out") / "before.png"),
            read_all(folder.file("out") / "after.png"));
}

/// Golden pictures: 64 x 64, 9 spp, 4 records, traced shadows, scalar kernels. Embree's own code
/// differs between processors, so a hit at an edge may fall on either side: the thresholds say how
/// many may.
class Golden : public testing::TestWithParam<const char*> {};

TEST_P(Golden, FrameLooksAsItDid) {
  const TemporaryFolder folder;
  const std::string scene = GetParam();
  const std::filesystem::path golden =
      std::filesystem::path(RELUME_SOURCE_DIR) / "tests/golden" / (scene + ".exr");
  const Outcome outcome = run_relume(
      folder,
      "render " + scene + " -q --width 64 --height 64 --spp 9 --records 4 --isa scalar -o f.exr");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  if (std::getenv("RELUME_UPDATE_GOLDEN") != nullptr) {
    std::filesystem::create_directories(golden.parent_path());
    std::filesystem::copy_file(folder.file("f.exr"), golden,
                               std::filesystem::copy_options::overwrite_existing);
  }
  const Image reference = read_image(golden);
  const Image frame = read_image(folder.file("f.exr"));
  const ImageError error = compare_images(frame, reference);
  EXPECT_LT(error.error_covered, 0.01 * error.reference_mean);
  const Image difference = error_image(frame, reference);
  const auto wrong = std::count_if(difference.pixels.begin(), difference.pixels.end(),
                                   [&](float d) { return d > 0.1 * error.reference_mean; });
  EXPECT_LT(wrong, 0.02 * static_cast<double>(difference.pixels.size()));
}

INSTANTIATE_TEST_SUITE_P(BuiltinScenes, Golden, testing::Values("hair", "plants", "spheres"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace relume::test
