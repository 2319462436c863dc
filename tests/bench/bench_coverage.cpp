// Measures shadow methods against a truth of many traced samples a pixel: mean absolute error of
// the visibility per pixel, its low frequencies, flicker along a path of the light, and
// milliseconds.
//
// Usage: bench_coverage SCENE WIDTH HEIGHT TRUTH_SPP RECORDS [METHOD...]
// METHOD "samples" is coverage with every sample a record. LIGHTS=n in the environment: the first
// n. MEMBERS=n: so many stored a record instead of all. PICTURES=DIR: visibilities go there as
// pictures, and a truth that lies there is read instead of made.

#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>

#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/image/image_io.h"
#include "core/samples/sample_scene.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "shadow/coverage.h"
#include "shadow/shadow.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

using Pixels = std::vector<float>;

struct NamedLight {
  std::string name;
  Light light;
};

Light make_point(vec3 position) {
  Light light;
  light.position = position;
  return light;
}

/// Beside, low, inside, overhead, then a path of three small steps from the first; parallel last.
/// Of scenes of files, their own.
std::vector<NamedLight> make_lights(const Scene& scene) {
  std::vector<NamedLight> own;
  for (const Light& light : scene.lights) own.push_back({light.name, light});
  if (!scene.file.empty()) return own;
  const bool is_hair = scene.name == "hair";
  const vec3 start = is_hair ? vec3(3, 4, 4) : vec3(-5, 5, 4);
  std::vector<NamedLight> lights = {
      {"beside", make_point(start)},
      {"low", make_point(is_hair ? vec3(-4, -0.5f, -2.5f) : vec3(-9, 1.2f, -3))},
      {"inside", make_point(is_hair ? vec3(0.3f, 0.9f, 0.75f) : vec3(-0.3f, 0.4f, 3.5f))},
      {"overhead", make_point(is_hair ? vec3(0, 5, 0) : vec3(0, 12, 2))}};
  for (int i = 1; i <= 3; ++i) {
    const float step = static_cast<float>(i) * (is_hair ? 0.012f : 0.02f);
    lights.push_back({fmt::format("step{}", i), make_point(start + step * vec3(1, -0.7f, -1))});
  }
  Light sun;
  sun.type = LightType::directional;
  sun.direction = {-0.6f, -0.8f, -0.35f};
  lights.push_back({"sun", sun});
  return lights;
}

/// Per light: visibility of each pixel's samples, -1 where there are none.
std::vector<Pixels> find_truth(const Scene& scene, const Tracer& tracer, int width, int height,
                               int spp, std::span<const NamedLight> lights) {
  const ViewSampler view = make_view_sampler(scene, tracer, width, height, spp, 99);
  std::vector<Pixels> truth(lights.size(), Pixels(static_cast<size_t>(width) * height, -1.0f));
  std::vector<ShadowRays> rays(lights.size(), ShadowRays(tracer));
  for (size_t l = 0; l < lights.size(); ++l) rays[l].aim(lights[l].light);
  parallel_for(static_cast<size_t>(tile_count(view)), 1, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const SampleTile tile = sample_tile(view, static_cast<int>(t));
      for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
        const size_t at = static_cast<size_t>(tile.y0 + pixel / tile.width) * width + tile.x0 +
                          pixel % tile.width;
        std::vector<int> seen(lights.size(), 0);
        int count = 0;
        for (size_t type = 0; type < tile.types.size(); ++type) {
          const SampleType& sample_type = view.types.types[type];
          const int normal = field_offset(sample_type, FieldSource::normal);
          const int bias = sample_type.offsets[bias_field];
          const TypedRows& rows = tile.types[type];
          for (uint32_t r = rows.first[pixel]; r < rows.first[pixel + 1]; ++r) {
            const float* v = &rows.values[size_t{r} * sample_type.width];
            vec3 n(0);
            if (normal >= 0) n = vec3(v[normal], v[normal + 1], v[normal + 2]);
            ++count;
            for (size_t l = 0; l < lights.size(); ++l) {
              seen[l] += rays[l].sees(vec3(v[0], v[1], v[2]), normal >= 0 ? &n : nullptr,
                                      sample_type.shader->two_sided_transmission, v[bias])
                             ? 1
                             : 0;
            }
          }
        }
        if (count == 0) continue;
        for (size_t l = 0; l < lights.size(); ++l) {
          truth[l][at] = static_cast<float>(seen[l]) / static_cast<float>(count);
        }
      }
    }
  });
  return truth;
}

/// Directory for pictures; empty = none.
std::filesystem::path picture_directory() {
  const char* directory = std::getenv("PICTURES");
  return directory != nullptr ? directory : "";
}

void write_picture(const std::string& name, const Pixels& pixels, int width, int height) {
  if (picture_directory().empty()) return;
  std::filesystem::create_directories(picture_directory());
  const Image image = make_map(width, height, pixels);
  const ExrLayer layer{"", {"Y"}, &image};
  write_exr(picture_directory() / (name + ".exr"), {&layer, 1});
}

/// find_truth, kept in the picture directory.
std::vector<Pixels> keep_truth(const std::string& name, const Scene& scene, const Tracer& tracer,
                               int width, int height, int spp, std::span<const NamedLight> lights) {
  const auto file_of = [&](const NamedLight& light) {
    return fmt::format("truth_{}_{}x{}_{}_{}", name, width, height, spp, light.name);
  };
  std::vector<Pixels> truth;
  if (!picture_directory().empty()) {
    for (const NamedLight& light : lights) {
      const auto path = picture_directory() / (file_of(light) + ".exr");
      if (std::filesystem::exists(path)) truth.push_back(read_exr_channel(path, "Y").pixels);
    }
    if (truth.size() == lights.size()) return truth;
  }
  truth = find_truth(scene, tracer, width, height, spp, lights);
  for (size_t l = 0; l < lights.size(); ++l) {
    write_picture(file_of(lights[l]), truth[l], width, height);
  }
  return truth;
}

Pixels pixel_visibility(const RelightCache& cache, const VisibilitySource& source) {
  const CacheInfo& info = cache.info();
  Pixels sum(static_cast<size_t>(info.width) * info.height, 0.0f);
  Pixels weight(sum.size(), 0.0f);
  std::vector<float> scratch;
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  std::vector<float> visibility;
  for (const PackedTile& tile : cache.tiles()) {
    size_t first = tile.first_slot * block_lanes;
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock block = cache.block(tile, b);
      const float* slot = decoder.floats(block, scratch);
      query_block(info, block, slot, first, source, visibility);
      size_t at = 0;
      for (size_t t = 0; t < info.types.size(); ++t) {
        for (int s = 0; s < block.slots[t]; ++s) {
          for (int lane = 0; lane < block.lanes; ++lane) {
            const size_t pixel =
                static_cast<size_t>(tile.y0 + block.pixels[lane] / tile_size) * info.width +
                tile.x0 + block.pixels[lane] % tile_size;
            sum[pixel] += slot[lane] * visibility[at + lane];
            weight[pixel] += slot[lane];
          }
          slot += (1 + info.types[t].width) * block_lanes;
          at += block_lanes;
          first += block_lanes;
        }
      }
    }
  }
  for (size_t i = 0; i < sum.size(); ++i) sum[i] = weight[i] > 0 ? sum[i] / weight[i] : -1.0f;
  return sum;
}

struct Errors {
  double mean = 0;  ///< of |difference|
  double bias = 0;  ///< mean of |Gaussian of the difference|, sigma 3 pixels
  double signed_mean = 0;
};

Errors find_errors(const Pixels& a, const Pixels& truth, int width, int height) {
  Errors errors;
  std::vector<double> difference(a.size());
  double count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const bool both = a[i] >= 0 && truth[i] >= 0;
    difference[i] = both ? double{a[i]} - truth[i] : 0;
    if (!both) continue;
    ++count;
    errors.mean += std::abs(difference[i]);
    errors.signed_mean += difference[i];
  }
  const auto smooth = [&](std::vector<double> from, int step_x, int step_y) {
    std::vector<double> out(from.size());
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        double norm = 0;
        for (int k = -9; k <= 9; ++k) {
          const int px = x + k * step_x;
          const int py = y + k * step_y;
          const double g = std::exp(-k * k / 18.0);
          norm += g;
          if (px < 0 || py < 0 || px >= width || py >= height) continue;
          sum += g * from[static_cast<size_t>(py) * width + px];
        }
        out[static_cast<size_t>(y) * width + x] = sum / norm;
      }
    }
    return out;
  };
  const std::vector<double> low = smooth(smooth(difference, 1, 0), 0, 1);
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] >= 0 && truth[i] >= 0) errors.bias += std::abs(low[i]);
  }
  errors.mean /= std::max(1.0, count);
  errors.bias /= std::max(1.0, count);
  errors.signed_mean /= std::max(1.0, count);
  return errors;
}

/// Mean |change - the truth's change| over the path.
double find_flicker(const std::vector<Pixels>& found, const std::vector<Pixels>& truth) {
  const size_t path[4] = {0, 4, 5, 6};
  double sum = 0;
  double count = 0;
  for (int step = 0; step < 3; ++step) {
    for (size_t i = 0; i < found[0].size(); ++i) {
      if (truth[0][i] < 0 || found[0][i] < 0) continue;
      const double a = double{found[path[step + 1]][i]} - found[path[step]][i];
      const double b = double{truth[path[step + 1]][i]} - truth[path[step]][i];
      sum += std::abs(a - b);
      ++count;
    }
  }
  return sum / std::max(1.0, count);
}

void measure(const std::string& name, VisibilitySource& source, const RelightCache& cache,
             std::span<const NamedLight> lights, const std::vector<Pixels>& truth) {
  std::vector<Pixels> found;
  for (size_t l = 0; l < lights.size(); ++l) {
    double ms = 1e30;
    double cpu_ms = 1e30;
    for (int repeat = 0; repeat < 2; ++repeat) {
      const Timer timer;
      const std::clock_t cpu_start = std::clock();
      source.prepare(lights[l].light);
      if (source.all_visibility().empty()) {
        parallel_for(cache.tiles().size(), 1, [&](size_t begin, size_t end) {
          const BlockDecoder decoder(cache, InstructionSet::automatic);
          std::vector<float> scratch;
          std::vector<float> visibility;
          for (size_t t = begin; t < end; ++t) {
            for (int b = 0; b < cache.tiles()[t].block_count; ++b) {
              const PackedBlock block = cache.block(cache.tiles()[t], b);
              query_block(cache.info(), block, decoder.floats(block, scratch), 0, source,
                          visibility);
            }
          }
        });
      }
      ms = std::min(ms, timer.ms());
      cpu_ms = std::min(cpu_ms, 1e3 * static_cast<double>(std::clock() - cpu_start) /
                                    static_cast<double>(CLOCKS_PER_SEC));
    }
    const Timer coarse_timer;
    source.prepare_share(lights[l].light, PixelShare::quarter);
    const double coarse_ms = coarse_timer.ms();
    source.prepare(lights[l].light);
    found.push_back(pixel_visibility(cache, source));
    const Errors errors =
        find_errors(found.back(), truth[l], cache.info().width, cache.info().height);
    write_picture(fmt::format("{}_{}", name, lights[l].name), found.back(), cache.info().width,
                  cache.info().height);
    fmt::print("{:10} {:9} mae {:.4f} bias {:.4f} signed {:+.4f} ms {:.0f} cpu {:.0f}", name,
               lights[l].name, errors.mean, errors.bias, errors.signed_mean, ms, cpu_ms);
    if (!source.all_visibility().empty()) fmt::print(" quarter {:.0f} ms", coarse_ms);
    if (const auto* coverage = dynamic_cast<const CoverageVisibility*>(&source)) {
      const CoverageStats& s = coverage->stats();
      fmt::print(
          " [build {:.0f} project {:.0f} shade {:.0f} trace {:.0f}; {:.2f}M recv {:.2f}M "
          "prim {:.0f}M tests]",
          s.build_ms, s.project_ms, s.shade_ms, s.trace_ms, static_cast<double>(s.receivers) * 1e-6,
          static_cast<double>(s.primitives) * 1e-6, static_cast<double>(s.tests) * 1e-6);
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
  if (lights.size() < 7) return;
  fmt::print("{:10} flicker {:.4f}\n", name, find_flicker(found, truth));
}

}  // namespace
}  // namespace relume

int main(int argc, char** argv) {
  using namespace relume;  // NOLINT
  if (argc < 6) return 2;
  const int width = std::atoi(argv[2]);
  const int height = std::atoi(argv[3]);
  const Scene scene = load_scene(argv[1], shader_table());
  const std::string name = scene.name;
  const Tracer tracer(scene);
  std::vector<NamedLight> lights = make_lights(scene);
  if (const char* count = std::getenv("LIGHTS")) lights.resize(std::atoi(count));
  const std::vector<Pixels> truth =
      keep_truth(name, scene, tracer, width, height, std::atoi(argv[4]), lights);
  PrepareParams params;
  params.width = width;
  params.height = height;
  params.reduction.method = ReductionMethod::strong_kmeans;
  params.reduction.records = std::atoi(argv[5]);
  const char* stored = std::getenv("MEMBERS");
  params.reduction.stored_members = stored != nullptr ? std::atoi(stored) : max_members;
  const RelightCache cache = prepare_in_memory(scene, tracer, params, {});
  std::vector<std::string> methods(argv + 6, argv + argc);
  std::erase_if(methods, [&](const std::string& method) {
    if (method != "samples") return false;
    params.reduction.method = ReductionMethod::all;
    const RelightCache all = prepare_in_memory(scene, tracer, params, {});
    const auto source = make_shadow(ShadowMethod::coverage, tracer, all);
    measure("samples", *source, all, lights, truth);
    return true;
  });
  if (methods.empty()) methods = {"ray", "members", "coverage"};
  for (const std::string& method : methods) {
    const Timer timer;
    const auto source = make_shadow(*value_of(shadow_method_labels, method), tracer, cache);
    fmt::print("{} made in {:.0f} ms\n", method, timer.ms());
    measure(method, *source, cache, lights, truth);
    fmt::print("{} keeps {} MB\n", method, source->memory_bytes() >> 20);
  }
  return 0;
}
