#include "tests/fuzz/read_targets.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "core/base/error.h"
#include "core/image/image_io.h"
#include "core/relight/receivers.h"
#include "core/samples/relight_cache.h"
#include "core/samples/sample_scene.h"
#include "core/scene/channel_map.h"
#include "core/scene/io/gltf.h"
#include "core/scene/io/hair_file.h"
#include "core/scene/io/json_node.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/io/obj.h"
#include "core/scene/io/pbrt.h"
#include "core/scene/io/ply_file.h"
#include "core/shade/shaders.h"
#include "viewer/aovs/aov_reader.h"
#include "viewer/commands/commands.h"
#include "viewer/frames/frame_header.h"
#include "viewer/session/session_file.h"

namespace relume::test {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_text(const fs::path& path, std::string_view text) {
  std::ofstream(path, std::ios::binary) << text;
}

void read_scene(const fs::path& path) {
  load_scene(path.string(), shader_table());
}

/// What is written again must be read, and written as the same text.
void expect_same_text(const std::string& first, const std::string& second) {
  if (first != second) {
    throw std::logic_error("what was written is read as something else: " + first.substr(0, 400));
  }
}

void read_lights(const fs::path& path) {
  const std::string text = format_lights(parse_lights(text_of(path), path.string()));
  expect_same_text(text, format_lights(parse_lights(text, "what was written")));
}

void read_session(const fs::path& path) {
  const std::string text = format_session(parse_session(text_of(path), path.string()));
  expect_same_text(text, format_session(parse_session(text, "what was written")));
}

void read_channel_map(const fs::path& path) {
  load_channel_map(path.string(), shader_table());
}

void read_obj(const fs::path& path) {
  Scene scene;
  scene.shaders.assign(shader_table().begin(), shader_table().end());
  load_obj(path, {}, scene);
}

/// A material library, by an OBJ file that uses it.
void read_mtl(const fs::path& path) {
  const fs::path obj = fs::path(path).replace_extension(".obj");
  write_text(obj, fmt::format("mtllib {}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\n"
                              "f 1/1 2/1 3/1\n",
                              path.filename().string()));
  try {
    read_obj(obj);
  } catch (...) {
    fs::remove(obj);
    throw;
  }
  fs::remove(obj);
}

void read_hair(const fs::path& path) {
  load_hair(path, {});
}

/// A scene's text of our own making.
void expect_json(const std::string& text) {
  try {
    const JsonDocument document(text, "a scene of our own");
  } catch (const Error& error) {
    throw std::logic_error(error.what());
  }
}

void read_gltf_file(const fs::path& path) {
  Scene scene;
  scene.shaders.assign(shader_table().begin(), shader_table().end());
  load_gltf(path, {}, scene);
  expect_json(gltf_scene_text(path));
}

void read_pbrt_file(const fs::path& path) {
  const std::string text = pbrt_scene_text(path);
  expect_json(text);
  parse_scene(text, path, shader_table());
}

void read_ply_file(const fs::path& path) {
  read_ply(path);
}

void read_cache(const fs::path& path) {
  const RelightCache cache = RelightCache::open(path, shader_table());
  (void)cache.coverage();
  (void)cache.predicted_error();
  (void)cache.record_counts();
  const ViewReceivers view(cache);
  for (size_t tile = 0; tile < view.tile_count(); ++tile) {
    view.visit_tile(tile, [](const ReceiverGroup&) {});
  }
}

/// Pictures: textures, references, frames to compare.
void read_picture(const fs::path& path) {
  (void)read_image_header(path);
  (void)read_image(path);
}

void read_frame(const fs::path& path) {
  (void)read_frame_header(path);
  (void)read_channel_names(path);
}

/// No NaN or infinity gets into a sample.
void expect_finite(const SampleTile& tile) {
  for (const TypedRows& rows : tile.types) {
    const auto is_fine = [](float value) { return std::isfinite(value); };
    if (!std::ranges::all_of(rows.values, is_fine) || !std::ranges::all_of(rows.weights, is_fine)) {
      throw std::logic_error("a sample is not finite");
    }
  }
}

void read_aov(const fs::path& path) {
  static const ChannelMap map = load_channel_map("relume", shader_table());
  static const Scene nothing;
  static const Tracer tracer(nothing);
  Scene scene;
  scene.shaders.assign(shader_table().begin(), shader_table().end());
  scene.camera.eye = {0, 2, 6};  // of the seed
  scene.camera.target = {0, 0.5f, 0};
  scene.camera.fov_y_deg = 40;
  AovSamples samples(path, map, 2, scene.camera);
  samples.visit_hits([](const AovHit&) {});
  if (samples.width() > 64 || samples.height() > 64) return;
  samples.cast_own_shadows();
  samples.add_materials(scene);
  const ViewSampler view =
      make_view_sampler(scene, tracer, samples.width(), samples.height(), samples.spp(), 1);
  const SampleSource source = samples.source();
  for (int tile = 0; tile < tile_count(view); ++tile) expect_finite(source.tile(view, tile));
}

/// A command line, an argument a line.
void read_command(const fs::path& path) {
  std::vector<std::string> words = {"relume"};
  std::istringstream text(text_of(path));
  for (std::string word; std::getline(text, word);) words.push_back(word);
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  const std::string error = check_command_line(static_cast<int>(argv.size()), argv.data());
  if (!error.empty()) throw Error(ErrorKind::input, error);
}

constexpr ReadTarget targets[] = {
    {"scene", ".json", read_scene},
    {"lights", ".json", read_lights},
    {"session", ".json", read_session},
    {"channels", ".json", read_channel_map},
    {"obj", ".obj", read_obj},
    {"mtl", ".mtl", read_mtl},
    {"hair", ".hair", read_hair},
    {"gltf", ".gltf", read_gltf_file},
    {"glb", ".glb", read_gltf_file},
    {"pbrt", ".pbrt", read_pbrt_file},
    {"ply", ".ply", read_ply_file},
    {"cache", ".relume", read_cache},
    {"exr", ".exr", read_picture},
    {"png", ".png", read_picture},
    {"jpeg", ".jpg", read_picture},
    {"frame", ".exr", read_frame},
    {"aov", ".exr", read_aov},
    {"deep", ".exr", read_aov},
    {"command", ".txt", read_command},
    {"packed", ".ply.gz", read_ply_file},
    {"tiff", ".tif", read_picture, true},
    {"targa", ".tga", read_picture, true},
    {"bmp", ".bmp", read_picture, true},
    {"hdr", ".hdr", read_picture, true},
};

}  // namespace

std::span<const ReadTarget> read_targets() {
  return targets;
}

const ReadTarget* find_read_target(std::string_view name) {
  const auto found = std::ranges::find(targets, name, &ReadTarget::name);
  return found == std::end(targets) ? nullptr : &*found;
}

HostileFolder::HostileFolder(const fs::path& seeds)
    : root_(fmt::format("/dev/shm/relume_hostile_{}", getpid())) {
  fs::create_directories(root_ / "file");
  if (seeds.empty()) return;
  fs::copy(seeds / "companions", root_ / "companions", fs::copy_options::overwrite_existing);
}

HostileFolder::~HostileFolder() {
  std::error_code ignored;
  fs::remove_all(root_, ignored);
}

fs::path HostileFolder::file(const ReadTarget& target) const {
  return root_ / "file" / fmt::format("hostile{}", target.extension);
}

ReadResult read_checked(const ReadTarget& target, const fs::path& path) {
  try {
    target.read(path);
    return ReadResult::accepted;
  } catch (const Error& error) {
    const std::string_view message = error.what();
    if (error.kind() != ErrorKind::input && error.kind() != ErrorKind::limit) {
      throw std::logic_error(
          fmt::format("a file ended in exit code {}: {}", error.exit_code(), message));
    }
    if (message.empty() || message.size() > 1000 ||
        std::ranges::any_of(message, [](char c) { return c >= 0 && c < ' '; })) {
      throw std::logic_error(fmt::format("not one clear line: {}", message));
    }
    return ReadResult::refused;
  } catch (const std::exception& error) {
    throw std::logic_error(fmt::format("an exception of another kind: {}", error.what()));
  }
}

}  // namespace relume::test
