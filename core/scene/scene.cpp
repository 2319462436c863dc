#include "core/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

std::vector<Bounds> all_local_bounds(const Scene& scene) {
  std::vector<Bounds> bounds;
  bounds.reserve(scene.prototypes.size());
  for (const Prototype& prototype : scene.prototypes) bounds.push_back(local_bounds(prototype));
  return bounds;
}

/// The checks of one scene, with its name for messages.
class Validator {
 public:
  explicit Validator(const Scene& scene)
      : scene_(scene),
        name_(scene.file.empty() ? fmt::format("scene \"{}\"", scene.name) : scene.file.string()) {}

  void run() const {
    check_view();
    for (const Texture& texture : scene_.textures) check_texture(texture);
    limit(scene_.materials.size(), max_materials, "materials");
    for (const Material& material : scene_.materials) check_material(material);
    check_counts();
    for (const Prototype& prototype : scene_.prototypes) check_prototype(prototype);
    check_instances();
    check_lights();
  }

 private:
  std::string place(std::string_view field) const { return fmt::format("{}: {}", name_, field); }

  void require(bool ok, std::string_view field, std::string_view what,
               std::string_view mend) const {
    if (!ok) throw input_error(place(field), what, mend);
  }

  void limit(uint64_t count, uint64_t most, std::string_view field) const {
    if (count <= most) return;
    throw limit_error(place(field), fmt::format("{} are too many", count),
                      fmt::format("the limit is {}", most));
  }

  void check_view() const;
  void check_texture(const Texture& texture) const;
  void check_material(const Material& material) const;
  void check_parameter(const MaterialParameter& parameter, const ShaderInfo& shader,
                       const std::string& field) const;
  void check_counts() const;
  void check_prototype(const Prototype& prototype) const;
  void check_mesh(const Mesh& mesh, const std::string& field) const;
  void check_triangles(const Mesh& mesh, const std::string& field) const;
  void check_curves(const Curves& curves, const std::string& field) const;
  void check_strand(const Curves& curves, size_t strand, const std::string& field) const;
  void check_instances() const;
  void check_lights() const;
  bool needs_strands(const Material& material) const;

  const Scene& scene_;
  std::string name_;
};

void Validator::check_view() const {
  const bool size_fits = scene_.width >= 1 && scene_.height >= 1 &&
                         scene_.width <= max_image_side && scene_.height <= max_image_side;
  if (!size_fits) {
    throw limit_error(place("image"), fmt::format("{} x {} pixels", scene_.width, scene_.height),
                      fmt::format("give a width and a height within [1, {}]", max_image_side));
  }
  const Camera& camera = scene_.camera;
  require(is_coordinate(camera.eye) && is_coordinate(camera.target) && is_finite(camera.up),
          "camera", "a coordinate is not finite or above 1e9", "give finite numbers");
  require(camera.fov_y_deg > 0 && camera.fov_y_deg < 179, "camera/fov_y_deg",
          "is not within (0, 179)", "give the full vertical angle in degrees");
  const dvec3 view = dvec3(camera.target) - dvec3(camera.eye);
  const dvec3 up(camera.up);
  require(glm::length(view) > 0, "camera/target", "is where the eye is", "move one of them");
  require(glm::length(glm::cross(view, up)) > 1e-6 * glm::length(view) * glm::length(up),
          "camera/up", "is zero or parallel to the view direction", "give another direction");
  require(is_finite(scene_.exposure) && std::abs(scene_.exposure) <= 64, "exposure",
          "is not within [-64, 64]", "give stops");
}

void Validator::check_texture(const Texture& texture) const {
  const bool size_fits = texture.width >= 1 && texture.height >= 1 &&
                         texture.width <= max_image_side && texture.height <= max_image_side;
  const bool complete =
      size_fits && texture.texels.size() ==
                       static_cast<size_t>(texture.width) * static_cast<size_t>(texture.height) * 4;
  require(complete, fmt::format("texture \"{}\"", texture.name),
          fmt::format("{} x {} pixels with {} bytes", texture.width, texture.height,
                      texture.texels.size()),
          "give 4 bytes a pixel");
}

void Validator::check_material(const Material& material) const {
  const std::string field = fmt::format("material \"{}\"", material.name);
  const auto shader_count = static_cast<int>(scene_.shaders.size());
  require(material.shader >= 0 && material.shader < shader_count, field, "has no shader",
          "name one of the program's shaders");
  const ShaderInfo& shader = *scene_.shaders[material.shader];
  for (const MaterialParameter& parameter : material.parameters) {
    check_parameter(parameter, shader, field);
  }
  const auto texture_count = static_cast<int>(scene_.textures.size());
  require(material.alpha_texture >= -1 && material.alpha_texture < texture_count, field,
          "refers to a missing alpha texture", "give an index of the scene's textures");
  require(material.alpha_cutoff >= 0 && material.alpha_cutoff <= 1, field + "/alpha/cutoff",
          "is not within [0, 1]", "0.5 is usual");
  require(material.normal_texture >= -1 && material.normal_texture < texture_count, field,
          "refers to a missing normal map", "give an index of the scene's textures");
  require(std::abs(material.normal_scale) <= 1000, field + "/normal_map/scale",
          "is not within [-1000, 1000]", "1 is usual");
  require(is_finite(material.emission) && max_component(-material.emission) <= 0 &&
              max_component(material.emission) <= max_emission,
          field + "/emission", "has a component that is negative, not finite or above 1e20",
          "give numbers >= 0");
  require(material.emission_texture >= -1 && material.emission_texture < texture_count, field,
          "refers to a missing emission texture", "give an index of the scene's textures");
  for (const auto& merge : material.merges) {
    const bool known = std::ranges::any_of(
        shader.fields, [&](const SampleField& f) { return f.name == merge.first; });
    require(known, field + "/merge", fmt::format("\"{}\" is no field of the shader", merge.first),
            "name one of its fields");
  }
}

void Validator::check_parameter(const MaterialParameter& parameter, const ShaderInfo& shader,
                                const std::string& field) const {
  const std::string at = field + "/" + parameter.name;
  const std::vector<SampleField> known = material_parameters(shader);
  const auto found = std::ranges::find(known, parameter.name, &SampleField::name);
  require(found != known.end(), at, fmt::format("is no parameter of shader \"{}\"", shader.name),
          "remove it or choose another shader");
  for (int i = 0; i < found->width; ++i) {
    const float value = parameter.value[i];
    require(value >= found->low && value <= found->high, at,
            fmt::format("{} is out of range", value),
            fmt::format("give values within [{}, {}]", found->low, found->high));
  }
  require(parameter.texture >= -1 && parameter.texture < static_cast<int>(scene_.textures.size()),
          at, "refers to a missing texture", "give an index of the scene's textures");
  require(parameter.channel >= 0 && parameter.channel < 4, at, "has no such channel",
          "give one within [0, 3]");
}

void Validator::check_counts() const {
  const SceneCounts counts = count_scene(scene_);
  limit(counts.triangles, max_triangles, "stored triangles");
  limit(counts.strands, max_strands, "strands");
  limit(counts.segments, max_segments, "strand segments");
  limit(scene_.instances.size(), max_instances, "instances");
  require(!scene_.instances.empty(), "geometry", "nothing is placed in the scene",
          "add an entry that is not only a prototype");
}

void Validator::check_prototype(const Prototype& prototype) const {
  const std::string field = fmt::format("geometry \"{}\"", prototype.name);
  require(!prototype.shapes.empty(), field, "is empty", "remove it or give it a shape");
  for (const auto& shape : prototype.shapes) {
    if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
      check_mesh(*mesh, field);
    } else {
      check_curves(std::get<Curves>(shape), field);
    }
  }
}

bool Validator::needs_strands(const Material& material) const {
  const auto& fields = scene_.shaders[material.shader]->fields;
  return std::any_of(fields.begin(), fields.end(),
                     [](const SampleField& f) { return f.source == FieldSource::tangent; });
}

void Validator::check_mesh(const Mesh& mesh, const std::string& field) const {
  const size_t vertices = mesh.positions.size();
  require(!mesh.triangles.empty(), field, "has no triangles", "give it some");
  limit(vertices, UINT32_MAX, field + " vertices");
  require(mesh.normals.empty() || mesh.normals.size() == vertices, field,
          fmt::format("{} normals for {} vertices", mesh.normals.size(), vertices),
          "give one a vertex or none");
  require(mesh.uvs.empty() || mesh.uvs.size() == vertices, field,
          fmt::format("{} texture coordinates for {} vertices", mesh.uvs.size(), vertices),
          "give one a vertex or none");
  require(mesh.tangents.empty() || mesh.tangents.size() == vertices, field,
          fmt::format("{} tangents for {} vertices", mesh.tangents.size(), vertices),
          "give one a vertex or none");
  const auto fail = [&](std::string_view item, size_t i, std::string_view what,
                        std::string_view mend) {
    throw input_error(place(fmt::format("{} {} {}", field, item, i)), what, mend);
  };
  for (size_t i = 0; i < vertices; ++i) {
    if (!is_coordinate(mesh.positions[i])) {
      fail("vertex", i, "is not finite or above 1e9", "give finite coordinates");
    }
  }
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    const float length = glm::length(mesh.normals[i]);
    if (!(std::abs(length - 1) <= 1e-3f)) fail("normal", i, "is not a unit vector", "normalise it");
  }
  for (size_t i = 0; i < mesh.uvs.size(); ++i) {
    if (!is_finite(mesh.uvs[i])) {
      fail("texture coordinate", i, "is not finite", "give finite numbers");
    }
  }
  for (size_t i = 0; i < mesh.tangents.size(); ++i) {
    if (!is_finite(vec3(mesh.tangents[i])) || std::abs(mesh.tangents[i].w) != 1) {
      fail("tangent", i, "is not finite or has a sign other than 1 or -1", "mend it");
    }
  }
  check_triangles(mesh, field);
}

void Validator::check_triangles(const Mesh& mesh, const std::string& field) const {
  const size_t vertices = mesh.positions.size();
  require(
      mesh.materials.size() == mesh.triangles.size(), field,
      fmt::format("{} materials for {} triangles", mesh.materials.size(), mesh.triangles.size()),
      "give one a triangle");
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uvec3 t = mesh.triangles[i];
    const uint32_t material = mesh.materials[i];
    if (t.x >= vertices || t.y >= vertices || t.z >= vertices) {
      throw input_error(
          place(fmt::format("{} triangle {}", field, i)),
          fmt::format("refers to vertex {} of {}", std::max({t.x, t.y, t.z}), vertices),
          "give indices of its vertices");
    }
    if (!has_area(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z])) {
      throw input_error(place(fmt::format("{} triangle {}", field, i)), "has no area", "remove it");
    }
    if (material >= scene_.materials.size()) {
      throw input_error(place(fmt::format("{} triangle {}", field, i)),
                        fmt::format("refers to material {}", material),
                        fmt::format("there are {}", scene_.materials.size()));
    }
    if (needs_strands(scene_.materials[material])) {
      throw input_error(place(field),
                        fmt::format("material \"{}\" has a shader for strands, but this is a mesh",
                                    scene_.materials[material].name),
                        "give the mesh a surface shader such as lambert or phong");
    }
  }
}

void Validator::check_curves(const Curves& curves, const std::string& field) const {
  require(curves.offsets.size() >= 2, field, "has no strands", "give it some");
  const size_t strands = curves.offsets.size() - 1;
  require(curves.offsets.front() == 0 && curves.offsets.back() == curves.points.size(), field,
          "the strands do not cover the points", "give strands + 1 offsets, from 0 to the points");
  require(curves.materials.size() == strands, field,
          fmt::format("{} materials for {} strands", curves.materials.size(), strands),
          "give one a strand");
  require(curves.colors.empty() || curves.colors.size() == strands, field,
          fmt::format("{} colours for {} strands", curves.colors.size(), strands),
          "give one a strand or none");
  for (size_t i = 0; i < strands; ++i) check_strand(curves, i, field);
}

void Validator::check_strand(const Curves& curves, size_t strand, const std::string& field) const {
  const uint32_t begin = curves.offsets[strand];
  const uint32_t end = curves.offsets[strand + 1];
  const auto fail = [&](std::string_view what, std::string_view mend) {
    throw input_error(place(fmt::format("{} strand {}", field, strand)), what, mend);
  };
  if (end > curves.points.size() || end < begin + uint64_t{2}) fail("has < 2 points", "remove it");
  if (curves.materials[strand] >= scene_.materials.size()) {
    fail("refers to a missing material", "give an index of the scene's materials");
  }
  if (!curves.colors.empty()) {
    const vec3 color = curves.colors[strand];
    const bool fits = glm::all(glm::greaterThanEqual(color, vec3(0))) &&
                      glm::all(glm::lessThanEqual(color, vec3(1)));
    if (!fits) fail("has a colour outside [0, 1]", "give a colour within");
  }
  for (uint32_t i = begin; i < end; ++i) {
    const vec4 p = curves.points[i];
    if (!is_coordinate(vec3(p)))
      fail("has a point that is not finite or above 1e9", "mend the point");
    if (!(p.w > 0 && p.w <= max_coordinate))
      fail("has a radius that is not above 0", "mend the radius");
    if (i > begin && vec3(curves.points[i - 1]) == vec3(p)) {
      fail("has two equal neighbouring points", "remove one");
    }
  }
}

void Validator::check_instances() const {
  const std::vector<Bounds> local = all_local_bounds(scene_);
  for (size_t i = 0; i < scene_.instances.size(); ++i) {
    const Instance& instance = scene_.instances[i];
    const mat4x3& m = instance.world_from_local;
    const auto fail = [&](std::string_view what, std::string_view mend) {
      throw input_error(place(fmt::format("instance {}", i)), what, mend);
    };
    if (instance.prototype >= scene_.prototypes.size()) fail("has no prototype", "give one");
    if (!(is_coordinate(m[0]) && is_coordinate(m[1]) && is_coordinate(m[2]) &&
          is_coordinate(m[3]))) {
      fail("its transform is not finite or above 1e9", "give finite numbers");
    }
    const double determinant = glm::dot(dvec3(m[0]), glm::cross(dvec3(m[1]), dvec3(m[2])));
    if (!(std::abs(determinant) > 1e-30))
      fail("its transform is singular", "give a scale that is not 0");
    const Bounds world = transform_bounds(local[instance.prototype], m);
    if (!is_coordinate(world.low) || !is_coordinate(world.high)) {
      fail("reaches beyond 1e9 in world space", "give a smaller scale or translation");
    }
  }
}

void Validator::check_lights() const {
  limit(scene_.lights.size(), max_lights, "lights");
  for (const Light& light : scene_.lights) {
    validate_light(light, place(fmt::format("light \"{}\"", light.name)));
  }
  validate_light(scene_.representative_low, place("representative_lights/0"));
  validate_light(scene_.representative_high, place("representative_lights/1"));
  require(can_interpolate(scene_.representative_low, scene_.representative_high),
          "representative_lights",
          "the two differ in type, falloff, casts_shadow or in having a range",
          "give them the same: only numbers are interpolated");
}

}  // namespace

Bounds local_bounds(const Prototype& prototype) {
  Bounds bounds;
  for (const auto& shape : prototype.shapes) {
    if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
      for (const vec3 p : mesh->positions) bounds.extend(p);
    } else {
      for (const vec4 p : std::get<Curves>(shape).points) {
        bounds.extend(vec3(p) - p.w);
        bounds.extend(vec3(p) + p.w);
      }
    }
  }
  return bounds;
}

bool has_emission(const Scene& scene) {
  return std::ranges::any_of(scene.materials, [](const Material& material) {
    return max_component(material.emission) > 0;
  });
}

void remove_emission(Scene& scene) {
  for (Material& material : scene.materials) {
    material.emission = vec3(0);
    material.emission_texture = -1;
  }
}

Bounds transform_bounds(const Bounds& local, const mat4x3& world_from_local) {
  Bounds bounds;
  for (int corner = 0; corner < 8 && !local.empty(); ++corner) {
    const vec3 p((corner & 1) != 0 ? local.high.x : local.low.x,
                 (corner & 2) != 0 ? local.high.y : local.low.y,
                 (corner & 4) != 0 ? local.high.z : local.low.z);
    bounds.extend(transform_point(world_from_local, p));
  }
  return bounds;
}

Bounds world_bounds(const Scene& scene) {
  const std::vector<Bounds> local = all_local_bounds(scene);
  Bounds bounds;
  for (const Instance& instance : scene.instances) {
    bounds.extend(transform_bounds(local[instance.prototype], instance.world_from_local));
  }
  return bounds;
}

SceneCounts count_scene(const Scene& scene) {
  std::vector<SceneCounts> parts(scene.prototypes.size());
  SceneCounts sum;
  for (size_t i = 0; i < parts.size(); ++i) {
    for (const auto& shape : scene.prototypes[i].shapes) {
      if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
        parts[i].triangles += mesh->triangles.size();
      } else {
        const Curves& curves = std::get<Curves>(shape);
        const size_t strands = curves.offsets.empty() ? 0 : curves.offsets.size() - 1;
        parts[i].strands += strands;
        parts[i].segments += curves.points.size() - std::min(strands, curves.points.size());
      }
    }
    sum.triangles += parts[i].triangles;
    sum.strands += parts[i].strands;
    sum.segments += parts[i].segments;
  }
  for (const Instance& instance : scene.instances) {
    if (instance.prototype >= parts.size()) continue;
    sum.instanced_triangles += parts[instance.prototype].triangles;
    sum.instanced_segments += parts[instance.prototype].segments;
  }
  return sum;
}

void validate_scene(const Scene& scene) {
  Validator(scene).run();
}

}  // namespace relume
