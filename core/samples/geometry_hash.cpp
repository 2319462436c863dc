#include "core/samples/geometry_hash.h"

#include "core/samples/cache_format.h"

namespace relume {
namespace {

/// A hash that is fed piece by piece.
class HashChain {
 public:
  /// `Value` has no padding.
  template <class Value>
  void add(std::span<const Value> values) {
    const uint64_t size = values.size();
    hash_ = hash_bytes(std::as_bytes(std::span(&size, 1)), hash_);
    hash_ = hash_bytes(std::as_bytes(values), hash_);
  }
  template <class Value>
  void add(const std::vector<Value>& values) {
    add(std::span<const Value>(values));
  }
  template <class Value>
  void add(const Value& value) {
    add(std::span<const Value>(&value, 1));
  }
  uint64_t value() const { return hash_; }

 private:
  uint64_t hash_ = 0;
};

void add_shape(const Mesh& mesh, HashChain& hash) {
  hash.add(mesh.positions);
  hash.add(mesh.uvs);
  hash.add(mesh.triangles);
  hash.add(mesh.materials);
}

void add_shape(const Curves& curves, HashChain& hash) {
  hash.add(curves.points);
  hash.add(curves.offsets);
}

void add_cut_out(const Scene& scene, const Material& material, HashChain& hash) {
  hash.add(material.alpha_texture);
  if (material.alpha_texture < 0) return;
  hash.add(static_cast<int>(material.alpha_from_luminance));
  hash.add(material.alpha_cutoff);
  const Texture& texture = scene.textures[material.alpha_texture];
  hash.add(texture.width);
  hash.add(texture.texels);
}

}  // namespace

uint64_t geometry_hash(const Scene& scene) {
  HashChain hash;
  for (const Prototype& prototype : scene.prototypes) {
    hash.add(prototype.shapes.size());
    for (const auto& shape : prototype.shapes) {
      hash.add(shape.index());
      std::visit([&](const auto& parts) { add_shape(parts, hash); }, shape);
    }
  }
  for (const Instance& instance : scene.instances) {
    hash.add(instance.prototype);
    hash.add(instance.world_from_local);
  }
  for (const Material& material : scene.materials) add_cut_out(scene, material, hash);
  return hash.value();
}

}  // namespace relume
