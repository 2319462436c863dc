// Random lights, records and scenes at the ends of what is permitted. Usage: check_numbers [CASES]
// [JSON] A case is one record under one light. Half come from records made at random, each held to
// the bound that its own conditioning gives (tests/support/response_bound.h) against the double
// reference; half from small scenes that are sampled and relit with traced shadows. Then: rays in
// closed meshes, as many as cases, of which 2e-5 may leave; and a furnace: white Lambert records
// under even light from all sides send it on within 1e-4. Exits with 1 where a figure misses its
// target. By ./dev numbers.

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/shade/reference.h"
#include "core/shade/shaders.h"
#include "shadow/traced.h"
#include "tests/support/records.h"
#include "tests/support/response_bound.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: record, scene and light builders

constexpr double largest_leak = 2e-5;
constexpr double largest_furnace_error = 1e-4;
/// Of scenes: error of a pixel over the layer's brightest one. Highlights are wide there.
constexpr double largest_scene_error = 1e-3;

/// Above this a pixel may be too bright for a float.
constexpr double largest_value = 0.9 * static_cast<double>(std::numeric_limits<float>::max());

/// How often something happened.
struct Counts {
  uint64_t record_cases = 0;
  uint64_t scene_cases = 0;
  uint64_t scenes = 0;
  uint64_t non_finite = 0;        ///< values left in a picture
  uint64_t out_of_bound = 0;      ///< further from the reference than the bound
  uint64_t refused_lights = 0;    ///< above a limit, told by validate_light
  uint64_t accepted_wrongly = 0;  ///< above a limit, not told
  uint64_t distance_guard = 0;    ///< nearer to the light than the least distance
  uint64_t range_guard = 0;       ///< beyond the light's range
  uint64_t too_bright = 0;        ///< above the largest float: black, and counted by the film
  uint64_t rays = 0;
  uint64_t leaks = 0;
  double worst_of_bound = 0;  ///< largest error over its bound
  double worst_scene = 0;     ///< largest error over the layer's brightest pixel
  double worst_furnace = 0;   ///< largest |reflected / arrived - 1|
};

/// 10^U(low, high).
float log_uniform(Random& random, float low, float high) {
  return std::pow(10.0f, random.uniform(low, high));
}

/// Anything from nothing to `high`.
float amount(Random& random, float low_exponent, float high_exponent) {
  const uint32_t choice = random.below(8);
  if (choice == 0) return 0;
  if (choice == 1) return 1;
  return log_uniform(random, low_exponent, high_exponent);
}

/// A light of any kind at a distance of 0 to 1e30 from `target`; above 1e15 it is refused.
Light make_light(Random& random, vec3 target) {
  Light light = make_point_light(target, 1, random.below(3) != 0);
  light.type = static_cast<LightType>(random.below(3));
  const float distance = random.below(10) == 0 ? 0 : log_uniform(random, -12, 15);
  light.position += (random.below(20) == 0 ? 1e30f : distance) * random_direction(random);
  light.direction = random.below(2) == 0 ? random_direction(random)
                                         : normalize_or(target - light.position, {0, -1, 0});
  light.outer_angle_deg = random.uniform(min_spot_angle_deg, 90);
  light.inner_angle_deg = random.uniform() * light.outer_angle_deg;
  if (random.below(3) == 0)
    light.range = std::clamp(distance * random.uniform(0.5f, 2), 1e-15f, 1e15f);
  light.color = {amount(random, -20, 20), amount(random, -20, 20), amount(random, -20, 20)};
  light.gain = amount(random, -18, 18);
  return light;
}

/// True where the light is permitted; counts what is not.
bool is_permitted(const Light& light, Counts& counts) {
  const bool within = max_abs_component(light.position) <= 1e15f;
  try {
    validate_light(light, "light");
    counts.accepted_wrongly += within ? 0 : 1;
    return within;
  } catch (const Error&) {
    ++counts.refused_lights;
    return false;
  }
}

/// One random record a pixel, in a ball of radius `scale`.
SampleTile make_tile(const SampleType& type, Random& random, float scale) {
  SampleTile tile;
  tile.width = tile_size;
  tile.height = tile_size;
  TypedRows& rows = tile.types.emplace_back();
  rows.first.push_back(0);
  for (uint32_t pixel = 0; pixel < static_cast<uint32_t>(tile.pixel_count()); ++pixel) {
    append_random_vector(type, random, rows.values);
    float* v = &rows.values[rows.values.size() - type.width];
    for (int i = 0; i < 4; ++i) v[i] *= scale;
    rows.weights.push_back(1);
    rows.first.push_back(pixel + 1);
  }
  return tile;
}

RelightCache make_cache(const SampleTile& tile, const SampleType& type, float scale) {
  CacheInfo info = make_tile_info(tile, {type}, vec3(0.5f, -1, 5) * scale);
  info.bounds = {};
  info.bounds.extend(vec3(-0.5773503f * scale));
  info.bounds.extend(vec3(0.5773503f * scale));
  CacheWriter writer;
  writer.add(pack_tile(tile, {&type, 1}));
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "records");
}

/// Counts what a correct kernel has to guard against in this case.
void count_guards(const RelightCache& cache, const Light& light, const float* v, Counts& counts) {
  if (light.type == LightType::directional) return;
  const double distance = glm::distance(dvec3(light.position), dvec3(v[0], v[1], v[2]));
  counts.distance_guard += distance < min_light_distance * cache.info().bounds.radius() ? 1 : 0;
  counts.range_guard += distance > reach_of(light) ? 1 : 0;
}

/// What a value may be off by. Layers, weights and pixels below the smallest normal float keep
/// fewer digits.
double tolerance_of(const ResponseBound& bound, int c, double weight) {
  return weight * (bound.tolerance[c] + 2e-44) + bound.exact[c] * (1e-6 * weight + 2e-44) + 2e-44;
}

/// Each value of the frame of one light against the double reference.
void check_records(const RelightCache& cache, const SampleTile& tile, const Light& light,
                   const Image& frame, Counts& counts) {
  const CacheInfo& info = cache.info();
  const SampleType& type = info.types[0];
  for (size_t pixel = 0; pixel < frame.pixels.size() / 3; ++pixel) {
    const float* v = &tile.types[0].values[pixel * type.width];
    ++counts.record_cases;
    count_guards(cache, light, v, counts);
    const auto make_bound = [&](int jitters) {
      return bound_response(type, v, light, dvec3(info.camera.eye), info.bounds.radius(), 0,
                            jitters);
    };
    ResponseBound bound = make_bound(24);
    for (int c = 0; c < 3; ++c) {
      const double weight = static_cast<double>(light.color[c]) * light.gain;
      const double value = frame.pixels[3 * pixel + static_cast<size_t>(c)];
      const double exact = weight * bound.exact[c];
      if (!std::isfinite(value)) {
        ++counts.non_finite;
        continue;
      }
      if (value == 0 && exact + weight * bound.tolerance[c] > largest_value) {
        ++counts.too_bright;
        continue;
      }
      const double error = std::abs(value - exact);
      // Few tries see too little of a sharp highlight.
      if (error > tolerance_of(bound, c, weight)) bound = make_bound(2000);
      const double tolerance = tolerance_of(bound, c, weight);
      counts.worst_of_bound = std::max(counts.worst_of_bound, error / tolerance);
      if (error <= tolerance) continue;
      ++counts.out_of_bound;
      fmt::print(stderr, "{} {} pixel {}: {} for {} +- {}; radius {}, weight {}\n", type.name,
                 label_of(light_type_labels, light.type), pixel, value, exact, tolerance,
                 info.bounds.radius(), weight);
    }
  }
}

void check_random_records(uint64_t cases, Counts& counts) {
  const std::vector<SampleType> types = all_sample_types();
  constexpr InstructionSet sets[] = {InstructionSet::scalar, InstructionSet::sse42,
                                     InstructionSet::avx2, InstructionSet::avx512};
  for (uint64_t batch = 0; counts.record_cases < cases; ++batch) {
    Random random(11, RandomStream::tests, batch);
    const SampleType& type = types[batch % types.size()];
    const float scale = log_uniform(random, -9, 9);
    const SampleTile tile = make_tile(type, random, scale);
    const RelightCache cache = make_cache(tile, type, scale);
    const InstructionSet set = sets[random.below(std::size(sets))];
    RelightState state = make_relight_state(cache);
    for (int i = 0; i < 4; ++i) {
      const float* v = &tile.types[0].values[random.below(256) * static_cast<size_t>(type.width)];
      const Light light = make_light(random, {v[0], v[1], v[2]});
      if (!is_permitted(light, counts)) continue;
      RelightParams params;
      params.instruction_set = is_supported(set) ? set : InstructionSet::scalar;
      relight(state, {&light, 1}, nullptr, params);
      check_records(cache, tile, light, state.frame, counts);
    }
  }
}

/// Few shapes, some of them twice at one place or without extent, at any scale.
Scene make_random_scene(Random& random, float scale) {
  Scene scene = make_empty_scene(make_camera({0, 1, 4}, {0, 0, 0}, 40), 16, 16);
  const uint32_t surface = add_material(scene, random.below(2) == 0 ? "lambert" : "leaf");
  const uint32_t hair = add_material(scene, "kajiya-kay");
  const uint32_t strands = random.below(4) == 0 ? 1 : random.below(30);
  for (uint32_t i = 0; i < strands; ++i) {
    const vec3 root = random_direction(random);
    const vec3 tip = root + 0.5f * random_direction(random);
    const float radius = log_uniform(random, -12, -1) / (random.below(2) == 0 ? scale : 1.0f);
    for (uint32_t copy = 0; copy <= random.below(2); ++copy) {
      add_shape(scene, make_strand(root, tip, std::clamp(radius, 1e-12f, 0.3f), 2, hair));
    }
  }
  for (uint32_t copy = 0; copy <= random.below(2); ++copy) {
    add_shape(scene, make_quad({0, -0.5f, 0}, {3, 0, 0}, {0, 0, -3}, surface));
    add_shape(scene,
              make_quad({0, -0.5f, 0}, {1, 0, 0}, {0, log_uniform(random, -9, 0), 0}, surface));
  }
  scene.lights = {make_point_light(2.0f * random_direction(random)),
                  make_spot_light({0, 3, 0}, {0, -1, 0}, 10, 40),
                  make_directional_light(random_direction(random)),
                  make_point_light(log_uniform(random, -9, 5) * random_direction(random))};
  return move_scene(scene, scale, vec3(0));
}

void check_scene(const Scene& scene, uint64_t seed, Counts& counts) {
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4, seed);
  TracedVisibility shadows(tracer);
  RelightState state = make_relight_state(cache);
  relight(state, scene.lights, &shadows, {});
  for (const float value : state.frame.pixels) counts.non_finite += std::isfinite(value) ? 0 : 1;
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    shadows.prepare(scene.lights[i]);
    const Image expected = reference_layer(cache, scene.lights[i], &shadows);
    const Image layer = layer_image(state, i);
    double brightest = 1e-37;
    double worst = 0;
    for (size_t p = 0; p < layer.pixels.size(); ++p) {
      brightest = std::max(brightest, static_cast<double>(expected.pixels[p]));
      worst = std::max(worst, std::abs(static_cast<double>(layer.pixels[p]) - expected.pixels[p]));
    }
    counts.worst_scene = std::max(counts.worst_scene, worst / brightest);
    counts.scene_cases += cache.info().record_count;
  }
  ++counts.scenes;
}

void check_random_scenes(uint64_t cases, Counts& counts) {
  for (uint64_t i = 0; counts.scene_cases < cases; ++i) {
    Random random(12, RandomStream::tests, i);
    check_scene(make_random_scene(random, log_uniform(random, -9, 8)), i, counts);
  }
}

/// A box of six quads that share their corners, each corner as large as the quads' arithmetic makes
/// it.
void add_box(Scene& scene, uint32_t material) {
  for (int axis = 0; axis < 3; ++axis) {
    vec3 u(0);
    vec3 v(0);
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = 1;
    for (const float side : {-1.0f, 1.0f}) {
      vec3 center(0);
      center[axis] = side;
      add_shape(scene, make_quad(center, u, v, material));
    }
  }
}

/// Rays from inside a closed mesh, half of them at its vertices and edges, where rays slip through.
void check_enclosure(uint64_t index, uint64_t rays, Counts& counts) {
  Random random(13, RandomStream::tests, index);
  Scene scene = make_empty_scene(make_camera({0, 1, 4}, {0, 0, 0}, 40), 16, 16);
  const uint32_t material = add_material(scene, "lambert");
  const bool is_box = random.below(3) == 0;
  const Mesh sphere = make_sphere(vec3(0), 1, 3 + static_cast<int>(random.below(30)), material);
  is_box ? add_box(scene, material) : add_shape(scene, sphere);
  const float scale = log_uniform(random, -9, 7);
  const vec3 offset = random.below(2) == 0 ? vec3(0) : 30 * scale * random_direction(random);
  const Scene moved = move_scene(scene, scale, offset);
  const Tracer tracer(moved);
  for (uint64_t i = 0; i < rays; ++i) {
    vec3 target = random_direction(random);
    if (i % 2 == 0) {
      const auto triangle =
          sphere.triangles[random.below(static_cast<uint32_t>(sphere.triangles.size()))];
      const float part = random.below(4) == 0 ? 0 : random.uniform();
      target = glm::mix(sphere.positions[triangle[0]], sphere.positions[triangle[1]], part);
      if (is_box) target = glm::mix(glm::sign(target), vec3(1, 1, glm::sign(target.z)), part);
    }
    Ray ray;
    const vec3 origin = 0.6f * random.uniform() * random_direction(random);
    ray.origin = scale * origin + offset;
    ray.direction = normalize_or(target - origin, {0, 0, 1});
    ++counts.rays;
    counts.leaks += tracer.occluded(ray) ? 0 : 1;
  }
}

/// The nodes and weights of Gauss and Legendre on [0, 1], for the integral of cos over a
/// hemisphere.
constexpr double gauss_nodes[] = {0.5 - 0.4305681557970263, 0.5 - 0.1699905217924281,
                                  0.5 + 0.1699905217924281, 0.5 + 0.4305681557970263};
constexpr double gauss_weights[] = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                    0.1739274225687269};

/// White Lambert records of one normal under even light: what arrives is sent on.
void check_furnace(uint64_t index, Counts& counts) {
  const SampleType lambert = all_sample_types()[0];
  Random random(14, RandomStream::tests, index);
  SampleTile tile = make_tile(lambert, random, 1);
  const vec3 n = random_direction(random);
  for (size_t row = 0; row < tile.types[0].rows(); ++row) {
    float* v = &tile.types[0].values[row * lambert.width];
    for (int c = 0; c < 3; ++c) {
      v[4 + c] = n[c];
      v[7 + c] = 1;
    }
  }
  const RelightCache cache = make_cache(tile, lambert, 1);
  const vec3 u = normalize_or(glm::cross(n, {0.36f, 0.48f, 0.8f}), {1, 0, 0});
  const vec3 v = glm::cross(n, u);
  std::vector<Light> lights;
  constexpr int azimuths = 8;
  for (int a = 0; a < azimuths; ++a) {
    for (int i = 0; i < 4; ++i) {
      const double phi = 2 * 3.14159265358979323846 * a / azimuths;
      const auto cosine = static_cast<float>(gauss_nodes[i]);
      const float sine = std::sqrt(1 - cosine * cosine);
      const vec3 wi = cosine * n + sine * (static_cast<float>(std::cos(phi)) * u +
                                           static_cast<float>(std::sin(phi)) * v);
      const double solid_angle = 2 * 3.14159265358979323846 * gauss_weights[i] / azimuths;
      lights.push_back(make_directional_light(-wi, static_cast<float>(solid_angle)));
    }
  }
  const Image frame = render_frame(cache, lights);
  for (const float value : frame.pixels) {
    counts.worst_furnace = std::max(counts.worst_furnace, std::abs(static_cast<double>(value) - 1));
  }
}

nlohmann::json to_json(const Counts& counts, uint64_t cases) {
  return {{"schema", "relume-numbers-1"},
          {"cases", cases},
          {"record_cases", counts.record_cases},
          {"scene_cases", counts.scene_cases},
          {"scenes", counts.scenes},
          {"non_finite", counts.non_finite},
          {"out_of_bound", counts.out_of_bound},
          {"worst_of_bound", counts.worst_of_bound},
          {"worst_scene_error", counts.worst_scene},
          {"refused_lights", counts.refused_lights},
          {"accepted_wrongly", counts.accepted_wrongly},
          {"distance_guard", counts.distance_guard},
          {"range_guard", counts.range_guard},
          {"too_bright", counts.too_bright},
          {"rays", counts.rays},
          {"leaks", counts.leaks},
          {"furnace_error", counts.worst_furnace},
          {"events", rare_events()}};
}

bool holds(const Counts& counts) {
  return counts.non_finite == 0 && counts.out_of_bound == 0 && counts.accepted_wrongly == 0 &&
         counts.worst_scene <= largest_scene_error &&
         counts.worst_furnace <= largest_furnace_error &&
         static_cast<double>(counts.leaks) <= largest_leak * static_cast<double>(counts.rays);
}

int run(int count, char** arguments) {
  const uint64_t cases = count > 1 ? std::stoull(arguments[1]) : 1'000'000;
  Counts counts;
  check_random_records((cases + 1) / 2, counts);
  check_random_scenes((cases + 1) / 2, counts);
  for (uint64_t i = 0; counts.rays < cases; ++i) check_enclosure(i, 5000, counts);
  for (uint64_t i = 0; i < 8; ++i) check_furnace(i, counts);
  const nlohmann::json document = to_json(counts, cases);
  fmt::print("{}\n", document.dump(1));
  if (count > 2) std::ofstream(arguments[2]) << document.dump(1) << "\n";
  return holds(counts) ? 0 : 1;
}

}  // namespace
}  // namespace relume

int main(int count, char** arguments) {
  try {
    return relume::run(count, arguments);
  } catch (const std::exception& failure) {
    fmt::print(stderr, "{}\n", failure.what());
    return 2;
  }
}
