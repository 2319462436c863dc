#include "core/samples/sample_scene.h"

#include "core/base/check.h"
#include "core/samples/record_layout.h"
#include "core/trace/texture_lookup.h"

namespace relume {
namespace {

RareEvent dropped_samples("samples dropped: a value was not finite");

ResolvedParameter resolve_parameter(const Material& material, const SampleField& field) {
  ResolvedParameter resolved{vec3(field.initial), -1, field.width == 1 ? 0 : -1,
                             field.name == "diffuse"};
  for (const MaterialParameter& parameter : material.parameters) {
    if (parameter.name != field.name) continue;
    resolved.value = parameter.value;
    resolved.texture = parameter.texture;
    if (field.width == 1) resolved.channel = parameter.channel;
  }
  return resolved;
}

std::vector<std::vector<ResolvedParameter>> resolve_parameters(const Scene& scene) {
  std::vector<std::vector<ResolvedParameter>> parameters;
  for (const Material& material : scene.materials) {
    std::vector<ResolvedParameter>& resolved = parameters.emplace_back();
    for (const SampleField& field : material_parameters(*scene.shaders[material.shader])) {
      resolved.push_back(resolve_parameter(material, field));
    }
  }
  return parameters;
}

/// Exponents closer to 0 count as 0: for them kernels do not tell 0^e = 0 from 0^0 = 1, see
/// pow_unit in core/simd/pack.h.
constexpr float smallest_scalar = 1e-30f;

vec3 parameter_value(const Scene& scene, const ResolvedParameter& parameter,
                     const SurfacePoint& point) {
  vec3 value = parameter.value;
  if (parameter.texture >= 0) {
    const vec4 texel = lookup_texture(scene.textures[parameter.texture], point.uv);
    value *= parameter.channel < 0 ? vec3(texel) : vec3(texel[parameter.channel]);
  }
  return parameter.strand_color ? value * point.color_scale : value;
}

/// Values of a shader's fields of FieldSource::material, in their order.
using MaterialValues = std::array<vec3, max_record_fields>;

MaterialValues material_values(const ViewSampler& view, const ShaderInfo& shader,
                               const SurfacePoint& point) {
  const std::vector<ResolvedParameter>& parameters = view.parameters[point.material];
  MaterialValues values;
  CHECK_MSG(parameters.size() <= values.size(), "parameters {}", parameters.size());
  for (size_t i = 0; i < parameters.size(); ++i) {
    values[i] = parameter_value(*view.scene, parameters[i], point);
  }
  if (shader.fields_of_parameters == nullptr) return values;
  MaterialValues fields;
  shader.fields_of_parameters(values.data(), fields.data());
  return fields;
}

/// `material` is the material's value, where the field has that source.
vec3 field_value(const SampleField& field, const SurfacePoint& point, vec3 material) {
  switch (field.source) {
    case FieldSource::position:
      return point.position;
    case FieldSource::bias:
      return vec3(point.bias);
    case FieldSource::normal:
      return point.shading_normal;
    case FieldSource::tangent:
      return point.tangent;
    case FieldSource::material: {
      const bool is_zero =
          field.kind == FieldKind::scalar && std::abs(material.x) < smallest_scalar;
      return is_zero ? vec3(0) : material;
    }
  }
  return vec3(0);
}

/// Appends the sample vector; leaves `rows` as it was and returns false when a value is not finite.
bool append_sample(const ViewSampler& view, const SampleType& type, const SurfacePoint& point,
                   float weight, TypedRows& rows) {
  const MaterialValues values = material_values(view, *type.shader, point);
  size_t next = 0;
  const size_t start = rows.values.size();
  rows.values.resize(start + type.width);
  for (size_t i = 0; i < type.field_count(); ++i) {
    const SampleField& field = type.field(i);
    const bool is_material = field.source == FieldSource::material;
    const vec3 value = field_value(field, point, is_material ? values[next++] : vec3(0));
    for (int c = 0; c < field.width; ++c) {
      if (!is_finite(value[c])) {
        rows.values.resize(start);
        dropped_samples.add();
        return false;
      }
      rows.values[start + type.offsets[i] + c] = value[c];
    }
  }
  rows.weights.push_back(weight);
  return true;
}

/// What the material sends out by itself; finite, since textures lie in [0, 1].
vec3 emission_at(const Scene& scene, const SurfacePoint& point) {
  const Material& material = scene.materials[point.material];
  if (material.emission_texture < 0) return material.emission;
  const Texture& texture = scene.textures[material.emission_texture];
  return material.emission * vec3(lookup_texture(texture, point.uv));
}

int tiles_across(int pixels) {
  return (pixels + tile_size - 1) / tile_size;
}

SampleTile sample_rectangle(const ViewSampler& view, const TileRectangle& place,
                            SampleCells* cells = nullptr) {
  if (cells != nullptr) cells->assign(view.types.types.size(), {});
  SampleTile tile;
  tile.x0 = place.x0;
  tile.y0 = place.y0;
  tile.width = place.width;
  tile.height = place.height;
  tile.types.resize(view.types.types.size());
  for (TypedRows& rows : tile.types) rows.first.push_back(0);
  if (view.emits) tile.emission.assign(static_cast<size_t>(tile.pixel_count()), vec3(0));
  const float weight = 1.0f / static_cast<float>(view.strata.spp);
  std::vector<vec2> positions;
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    const int x = tile.x0 + pixel % tile.width;
    const int y = tile.y0 + pixel / tile.width;
    positions.clear();
    sample_pixel(view.strata, view.seed,
                 static_cast<uint64_t>(y) * static_cast<uint64_t>(view.width) + x, positions);
    for (size_t cell = 0; cell < positions.size(); ++cell) {
      const Ray ray{.origin = view.rays.eye(),
                    .direction = view.rays.direction(vec2(x, y) + positions[cell])};
      const std::optional<SurfacePoint> point = view.tracer->intersect(ray);
      if (!point) continue;
      const uint16_t type = view.types.type_of_material[point->material];
      const bool is_kept =
          append_sample(view, view.types.types[type], *point, weight, tile.types[type]);
      if (is_kept && view.emits) tile.emission[pixel] += weight * emission_at(*view.scene, *point);
      if (is_kept && cells != nullptr) (*cells)[type].push_back(static_cast<uint16_t>(cell));
    }
    for (TypedRows& rows : tile.types) rows.first.push_back(static_cast<uint32_t>(rows.rows()));
  }
  return tile;
}

}  // namespace

ViewSampler make_view_sampler(const Scene& scene, const Tracer& tracer, int width, int height,
                              int spp, uint64_t seed) {
  return {&scene,
          &tracer,
          make_sample_types(scene),
          CameraRays(scene.camera, width, height),
          make_pixel_strata(spp),
          seed,
          width,
          height,
          resolve_parameters(scene),
          has_emission(scene)};
}

int tile_count(const ViewSampler& view) {
  return tiles_across(view.width) * tiles_across(view.height);
}

TileRectangle tile_rectangle(const ViewSampler& view, int index) {
  const int across = tiles_across(view.width);
  const int x0 = index % across * tile_size;
  const int y0 = index / across * tile_size;
  return {x0, y0, std::min(tile_size, view.width - x0), std::min(tile_size, view.height - y0)};
}

SampleTile sample_tile(const ViewSampler& view, int index) {
  return sample_rectangle(view, tile_rectangle(view, index));
}

SampleTile sample_tile(const ViewSampler& view, int index, SampleCells& cells) {
  return sample_rectangle(view, tile_rectangle(view, index), &cells);
}

SampleTile sample_one_pixel(const ViewSampler& view, int x, int y) {
  CHECK_MSG(x >= 0 && x < view.width && y >= 0 && y < view.height, "pixel {} {}", x, y);
  return sample_rectangle(view, {x, y, 1, 1});
}

}  // namespace relume
