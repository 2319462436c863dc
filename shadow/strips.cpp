#include "shadow/strips.h"

#include "shadow/morton.h"

namespace relume {
namespace {

/// Mean over the texels of whether the mask lets a hit stand.
float mask_fill(const Texture& mask, const Material& material) {
  if (mask.texels.empty()) return 1;
  uint64_t solid = 0;
  const size_t texels = mask.texels.size() / 4;
  for (size_t i = 0; i < texels; ++i) {
    const uint8_t* texel = &mask.texels[4 * i];
    const float value = material.alpha_from_luminance
                            ? static_cast<float>(texel[0] + texel[1] + texel[2]) / 3
                            : static_cast<float>(texel[3]);
    if (value >= material.alpha_cutoff * 255) ++solid;
  }
  return static_cast<float>(solid) / static_cast<float>(texels);
}

}  // namespace

SceneStrips::SceneStrips(const Scene& scene, bool all) : scene_(scene) {
  for (const Material& material : scene.materials) {
    const bool has_mask = material.alpha_texture >= 0;
    material_fill_.push_back(has_mask ? mask_fill(scene.textures[material.alpha_texture], material)
                                      : 1.0f);
    material_thin_.push_back(has_mask || scene.shaders[material.shader]->two_sided_transmission);
  }
  std::vector<uint64_t> copies(scene.prototypes.size(), 0);
  for (const Instance& instance : scene.instances) ++copies[instance.prototype];
  for (const uint64_t count : copies) many_.push_back(all || count >= thin_copies);
  // Bounds and counts once a prototype, in its own space.
  std::vector<Bounds> local(scene.prototypes.size());
  std::vector<uint64_t> pieces(scene.prototypes.size(), 0);
  has_triangles_.assign(scene.prototypes.size(), false);
  triangles_.assign(scene.prototypes.size(), 0);
  for (size_t p = 0; p < scene.prototypes.size(); ++p) {
    for (const auto& shape : scene.prototypes[p].shapes) {
      if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
        triangles_[p] += static_cast<uint32_t>(mesh->triangles.size());
        for (size_t t = 0; t < mesh->triangles.size(); ++t) {
          if (!is_thin(*mesh, t, many_[p])) continue;
          ++pieces[p];
          has_triangles_[p] = true;
          for (int c = 0; c < 3; ++c) local[p].extend(mesh->positions[mesh->triangles[t][c]]);
        }
        continue;
      }
      const Curves& curves = std::get<Curves>(shape);
      pieces[p] += curves.points.size() - (curves.offsets.size() - 1);
      for (const vec4 point : curves.points) {
        local[p].extend(vec3(point) - point.w);
        local[p].extend(vec3(point) + point.w);
      }
    }
  }
  for (const Instance& instance : scene.instances) {
    const Bounds& box = local[instance.prototype];
    instance_bounds_.push_back(box.empty() ? Bounds()
                                           : transform_bounds(box, instance.world_from_local));
    bounds_.extend(instance_bounds_.back());
    count_ += pieces[instance.prototype];
  }
}

StrandSet SceneStrips::strands() const {
  struct Root {
    uint32_t key;
    uint32_t instance;
    const Curves* curves;
    uint32_t strand;
  };
  std::vector<Root> roots;
  for (size_t i = 0; i < scene_.instances.size(); ++i) {
    const Instance& placed = scene_.instances[i];
    for (const auto& shape : scene_.prototypes[placed.prototype].shapes) {
      const Curves* curves = std::get_if<Curves>(&shape);
      if (curves == nullptr) continue;
      for (uint32_t strand = 0; strand + 1 < curves->offsets.size(); ++strand) {
        const vec3 root =
            transform_point(placed.world_from_local, vec3(curves->points[curves->offsets[strand]]));
        roots.push_back({morton_code(bounds_, root), static_cast<uint32_t>(i), curves, strand});
      }
    }
  }
  std::ranges::stable_sort(roots, {}, &Root::key);
  StrandSet set;
  for (const Root& root : roots) {
    const mat4x3& m = scene_.instances[root.instance].world_from_local;
    const float scale = uniform_scale(m);
    const uint32_t end = root.curves->offsets[root.strand + 1];
    for (uint32_t p = root.curves->offsets[root.strand]; p < end; ++p) {
      const vec4 point = root.curves->points[p];
      if (p + 1 < end) set.segments.push_back(static_cast<uint32_t>(set.points.size()));
      set.points.emplace_back(transform_point(m, vec3(point)), scale * point.w);
    }
  }
  return set;
}

Scene SceneStrips::solids() const {
  Scene solids;
  solids.name = scene_.name;
  solids.shaders = scene_.shaders;
  solids.instancing = scene_.instancing;
  for (const Material& material : scene_.materials) {
    Material& plain = solids.materials.emplace_back();
    plain.name = material.name;
    plain.shader = material.shader;
  }
  std::vector<int> kept(scene_.prototypes.size(), -1);
  for (size_t p = 0; p < scene_.prototypes.size(); ++p) {
    Prototype prototype{scene_.prototypes[p].name, {}};
    for (const auto& shape : scene_.prototypes[p].shapes) {
      const Mesh* mesh = std::get_if<Mesh>(&shape);
      if (mesh == nullptr) continue;
      Mesh solid{mesh->positions, {}, {}, {}, {}};
      for (size_t t = 0; t < mesh->triangles.size(); ++t) {
        if (is_thin(*mesh, t, many_[p])) continue;
        solid.triangles.push_back(mesh->triangles[t]);
        solid.materials.push_back(mesh->materials[t]);
      }
      if (!solid.triangles.empty()) prototype.shapes.emplace_back(std::move(solid));
    }
    if (prototype.shapes.empty()) continue;
    kept[p] = static_cast<int>(solids.prototypes.size());
    solids.prototypes.push_back(std::move(prototype));
  }
  for (const Instance& instance : scene_.instances) {
    if (kept[instance.prototype] < 0) continue;
    solids.instances.push_back(
        {static_cast<uint32_t>(kept[instance.prototype]), instance.world_from_local});
  }
  return solids;
}

}  // namespace relume
