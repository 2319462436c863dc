#include "core/trace/tracer.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/thread_sanitizer.h"
#include "core/base/timer.h"
#include "core/math/frame.h"
#include "core/trace/normal_map.h"
#include "core/trace/ray_bias.h"
#include "core/trace/texture_lookup.h"

namespace relume {
namespace {

/// Flattened copies may use this much, or an eighth of the machine's memory if that is less.
constexpr uint64_t flatten_budget_bytes = uint64_t{2} << 30;
// Measured with Embree 3.13, medium build quality, vertices included.
constexpr uint64_t bytes_per_triangle = 110;
constexpr uint64_t bytes_per_segment = 80;

/// One shape as Embree holds it, with what is needed to interpret a hit.
struct Geometry {
  const Scene* scene = nullptr;
  const Mesh* mesh = nullptr;
  const Curves* curves = nullptr;
  mat4x3 world_from_local = identity_transform();  ///< of the flattened copy
  const Instance* instance = nullptr;              ///< of the flattened copy
  uint32_t shape = 0;                              ///< within its prototype
  std::vector<uint32_t> segment_strand;            ///< per curve segment: its strand
};

uint64_t memory_budget() {
  const auto physical = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                        static_cast<uint64_t>(sysconf(_SC_PAGE_SIZE));
  return std::min(flatten_budget_bytes, physical / 8);
}

uint64_t flattened_bytes(const Prototype& prototype) {
  uint64_t bytes = 0;
  for (const auto& shape : prototype.shapes) {
    if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
      bytes += mesh->triangles.size() * bytes_per_triangle;
    } else {
      bytes += std::get<Curves>(shape).points.size() * bytes_per_segment;
    }
  }
  return bytes;
}

/// Which prototypes get a copy per instance: all when they fit the budget (3x faster rays), else
/// only those placed once. A mixture was measured to cost its memory and build time and gain
/// nothing.
std::vector<bool> choose_flattened(const Scene& scene) {
  std::vector<uint64_t> copies(scene.prototypes.size(), 0);
  for (const Instance& instance : scene.instances) ++copies[instance.prototype];
  uint64_t cost = 0;
  for (size_t i = 0; i < copies.size(); ++i) {
    cost += copies[i] * flattened_bytes(scene.prototypes[i]);
  }
  const bool all = scene.instancing == Instancing::flatten ||
                   (scene.instancing == Instancing::automatic && cost <= memory_budget());
  std::vector<bool> flatten(copies.size());
  for (size_t i = 0; i < copies.size(); ++i) flatten[i] = all || copies[i] <= 1;
  return flatten;
}

float mask_value(const Scene& scene, const Material& material, vec2 uv) {
  const vec4 texel = lookup_texture(scene.textures[material.alpha_texture], uv);
  return material.alpha_from_luminance ? (texel.x + texel.y + texel.z) / 3.0f : texel.w;
}

vec2 interpolate_uv(const Mesh& mesh, uvec3 corner, float u, float v) {
  if (mesh.uvs.empty()) return vec2(0);
  return mesh.uvs[corner.x] * (1 - u - v) + mesh.uvs[corner.y] * u + mesh.uvs[corner.z] * v;
}

/// Embree calls this for every candidate hit on a mesh with cut-outs: rejects the transparent ones.
void cut_out_filter(const RTCFilterFunctionNArguments* args) {
  CHECK(args->N == 1);
  const auto& geometry = *static_cast<const Geometry*>(args->geometryUserPtr);
  const unsigned prim = RTCHitN_primID(args->hit, 1, 0);
  const Material& material = geometry.scene->materials[geometry.mesh->materials[prim]];
  if (material.alpha_texture < 0) return;
  const vec2 uv = interpolate_uv(*geometry.mesh, geometry.mesh->triangles[prim],
                                 RTCHitN_u(args->hit, 1, 0), RTCHitN_v(args->hit, 1, 0));
  if (mask_value(*geometry.scene, material, uv) < material.alpha_cutoff) args->valid[0] = 0;
}

bool has_cut_outs(const Scene& scene, const Mesh& mesh) {
  return std::any_of(mesh.materials.begin(), mesh.materials.end(), [&](uint32_t material) {
    return scene.materials[material].alpha_texture >= 0;
  });
}

RTCRayHit make_embree_ray(const Ray& ray) {
  RTCRayHit query{};
  query.ray.org_x = ray.origin.x;
  query.ray.org_y = ray.origin.y;
  query.ray.org_z = ray.origin.z;
  query.ray.tnear = ray.t_near;
  query.ray.dir_x = ray.direction.x;
  query.ray.dir_y = ray.direction.y;
  query.ray.dir_z = ray.direction.z;
  query.ray.tfar = ray.t_far;
  query.ray.mask = 0xffffffffu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

}  // namespace

struct Tracer::Impl {
  const Scene& scene;
  RTCDevice device = nullptr;
  RTCScene top = nullptr;
  std::vector<RTCScene> prototype_scenes;
  std::vector<std::unique_ptr<Geometry>> geometries;          ///< by geometry id of the top scene
  std::vector<std::vector<std::unique_ptr<Geometry>>> parts;  ///< by prototype and geometry id
  std::vector<const Instance*> instance_of;                   ///< by geometry id of the top scene
  std::atomic<int64_t> embree_bytes{0};
  TracerStats stats;
  Bounds bounds;

  explicit Impl(const Scene& s) : scene(s) {}
  ~Impl() {
    for (RTCScene part : prototype_scenes) {
      if (part != nullptr) rtcReleaseScene(part);
    }
    if (top != nullptr) rtcReleaseScene(top);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  void build();
  std::unique_ptr<Geometry> attach(RTCScene target, const std::variant<Mesh, Curves>& shape,
                                   const mat4x3& transform);
  void attach_mesh(RTCGeometry handle, Geometry& geometry);
  void attach_curves(RTCGeometry handle, Geometry& geometry);
  void build_prototype(size_t index);
  void attach_instance(const Instance& instance);
  void check_device() const;
  SurfacePoint mesh_point(const Geometry& geometry, const mat4x3& world_from_local,
                          const RTCRayHit& hit, const Ray& ray) const;
  vec3 shading_normal(const MeshPoint& point, const Material& material,
                      const mat4x3& world_from_local, vec3 geometric, vec3 wo) const;
  SurfacePoint strand_point(const Geometry& geometry, const mat4x3& world_from_local,
                            const RTCRayHit& hit, const Ray& ray) const;
};

void Tracer::Impl::check_device() const {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    throw limit_error(scene.name, "the ray tracer ran out of memory",
                      "set \"instancing\": \"instance\" or use less geometry");
  }
  throw Error(ErrorKind::limit, fmt::format("{}: Embree error {}", scene.name, int{error}));
}

void Tracer::Impl::attach_mesh(RTCGeometry handle, Geometry& geometry) {
  const Mesh& mesh = *geometry.mesh;
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      handle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), mesh.positions.size()));
  check_device();
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec3 p = transform_point(geometry.world_from_local, mesh.positions[i]);
    vertices[3 * i] = p.x;
    vertices[3 * i + 1] = p.y;
    vertices[3 * i + 2] = p.z;
  }
  rtcSetSharedGeometryBuffer(handle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.triangles.data(), 0, sizeof(uvec3), mesh.triangles.size());
  if (has_cut_outs(scene, mesh)) {
    rtcSetGeometryIntersectFilterFunction(handle, cut_out_filter);
    rtcSetGeometryOccludedFilterFunction(handle, cut_out_filter);
  }
}

void Tracer::Impl::attach_curves(RTCGeometry handle, Geometry& geometry) {
  const Curves& curves = *geometry.curves;
  const float radius_scale = uniform_scale(geometry.world_from_local);
  auto* vertices = static_cast<vec4*>(rtcSetNewGeometryBuffer(
      handle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, sizeof(vec4), curves.points.size()));
  check_device();
  for (size_t i = 0; i < curves.points.size(); ++i) {
    const vec4 p = curves.points[i];
    vertices[i] = vec4(transform_point(geometry.world_from_local, vec3(p)), p.w * radius_scale);
  }
  const size_t strands = curves.offsets.size() - 1;
  const size_t segments = curves.points.size() - strands;
  auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      handle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, sizeof(uint32_t), segments));
  check_device();
  geometry.segment_strand.resize(segments);
  size_t segment = 0;
  for (size_t strand = 0; strand < strands; ++strand) {
    for (uint32_t p = curves.offsets[strand]; p + 1 < curves.offsets[strand + 1]; ++p) {
      indices[segment] = p;
      geometry.segment_strand[segment++] = static_cast<uint32_t>(strand);
    }
  }
  CHECK_MSG(segment == segments, "segments {} of {}", segment, segments);
}

std::unique_ptr<Geometry> Tracer::Impl::attach(RTCScene target,
                                               const std::variant<Mesh, Curves>& shape,
                                               const mat4x3& transform) {
  auto geometry = std::make_unique<Geometry>();
  geometry->scene = &scene;
  geometry->mesh = std::get_if<Mesh>(&shape);
  geometry->curves = std::get_if<Curves>(&shape);
  geometry->world_from_local = transform;
  const RTCGeometry handle =
      rtcNewGeometry(device, geometry->mesh != nullptr ? RTC_GEOMETRY_TYPE_TRIANGLE
                                                       : RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE);
  if (geometry->mesh != nullptr) {
    attach_mesh(handle, *geometry);
  } else {
    attach_curves(handle, *geometry);
  }
  rtcSetGeometryUserData(handle, geometry.get());
  rtcCommitGeometry(handle);
  rtcAttachGeometry(target, handle);
  rtcReleaseGeometry(handle);
  check_device();
  return geometry;
}

void Tracer::Impl::build_prototype(size_t index) {
  const RTCScene part = rtcNewScene(device);
  prototype_scenes[index] = part;
  rtcSetSceneFlags(part, RTC_SCENE_FLAG_ROBUST);
  for (const auto& shape : scene.prototypes[index].shapes) {
    parts[index].push_back(attach(part, shape, identity_transform()));
    parts[index].back()->shape = static_cast<uint32_t>(parts[index].size() - 1);
  }
  rtcCommitScene(part);
  check_device();
}

void Tracer::Impl::attach_instance(const Instance& instance) {
  if (prototype_scenes[instance.prototype] == nullptr) build_prototype(instance.prototype);
  const RTCGeometry handle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(handle, prototype_scenes[instance.prototype]);
  rtcSetGeometryTransform(handle, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &instance.world_from_local);
  rtcCommitGeometry(handle);
  rtcAttachGeometry(top, handle);
  rtcReleaseGeometry(handle);
  geometries.push_back(nullptr);
  instance_of.push_back(&instance);
}

void Tracer::Impl::build() {
  const Timer timer;
  device = rtcNewDevice(nullptr);
  CHECK(device != nullptr);
  __tsan_release(this);  // construction before the calls below, which come from oneTBB's threads
  rtcSetDeviceMemoryMonitorFunction(
      device,
      // Called inside Embree, whose hand-over between threads ThreadSanitizer cannot see.
      [](void* user, ssize_t bytes, bool) __attribute__((no_sanitize("thread"))) {
        __tsan_acquire(user);
        static_cast<Impl*>(user)->embree_bytes += bytes;
        return true;
      },
      this);
  top = rtcNewScene(device);
  rtcSetSceneFlags(top, RTC_SCENE_FLAG_ROBUST);
  prototype_scenes.resize(scene.prototypes.size(), nullptr);
  parts.resize(scene.prototypes.size());
  const std::vector<bool> flatten = choose_flattened(scene);
  stats.flattened = true;
  for (const Instance& instance : scene.instances) {
    if (!flatten[instance.prototype]) {
      stats.flattened = false;
      attach_instance(instance);
      continue;
    }
    uint32_t number = 0;
    for (const auto& shape : scene.prototypes[instance.prototype].shapes) {
      if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
        stats.flattened_triangles += mesh->triangles.size();
      }
      geometries.push_back(attach(top, shape, instance.world_from_local));
      geometries.back()->instance = &instance;
      geometries.back()->shape = number++;
      instance_of.push_back(nullptr);
    }
  }
  rtcCommitScene(top);
  check_device();
  RTCBounds box;
  rtcGetSceneBounds(top, &box);
  bounds.low = vec3(box.lower_x, box.lower_y, box.lower_z);
  bounds.high = vec3(box.upper_x, box.upper_y, box.upper_z);
  stats.memory_bytes = static_cast<uint64_t>(std::max<int64_t>(0, embree_bytes.load()));
  stats.build_ms = timer.ms();
}

SurfacePoint Tracer::Impl::mesh_point(const Geometry& geometry, const mat4x3& world_from_local,
                                      const RTCRayHit& hit, const Ray& ray) const {
  const Mesh& mesh = *geometry.mesh;
  const uvec3 corner = mesh.triangles[hit.hit.primID];
  const float u = hit.hit.u;
  const float v = hit.hit.v;
  const vec3 p0 = transform_point(world_from_local, mesh.positions[corner.x]);
  const vec3 p1 = transform_point(world_from_local, mesh.positions[corner.y]);
  const vec3 p2 = transform_point(world_from_local, mesh.positions[corner.z]);
  const vec3 wo = -glm::normalize(ray.direction);
  SurfacePoint point;
  // From the vertices, not from the ray: exact to the last bits of the coordinates at any distance.
  point.position = p0 + (p1 - p0) * u + (p2 - p0) * v;
  point.bias = surface_bias(p0, p1, p2);
  vec3 normal = normalize_or(vec3(glm::cross(dvec3(p1) - dvec3(p0), dvec3(p2) - dvec3(p0))), wo);
  if (glm::dot(normal, wo) < 0) normal = -normal;
  point.geometric_normal = normal;
  point.tangent = vec3(0);
  point.uv = interpolate_uv(mesh, corner, u, v);
  point.material = mesh.materials[hit.hit.primID];
  point.shading_normal =
      shading_normal({mesh, corner, u, v, point.uv}, scene.materials[point.material],
                     world_from_local, normal, wo);
  return point;
}

vec3 Tracer::Impl::shading_normal(const MeshPoint& point, const Material& material,
                                  const mat4x3& world_from_local, vec3 geometric, vec3 wo) const {
  const Mesh& mesh = point.mesh;
  if (mesh.normals.empty() && material.normal_texture < 0) return geometric;
  vec3 normal = geometric;
  if (!mesh.normals.empty()) {
    const vec3 local = mesh.normals[point.corner.x] * (1 - point.u - point.v) +
                       mesh.normals[point.corner.y] * point.u +
                       mesh.normals[point.corner.z] * point.v;
    normal = normalize_or(transform_normal(world_from_local, local), geometric);
  }
  const bool is_behind = glm::dot(normal, geometric) < 0;
  if (material.normal_texture >= 0) {
    normal = map_normal(scene.textures[material.normal_texture], material.normal_scale, point,
                        world_from_local, normal);
  }
  if (is_behind) normal = -normal;
  // Interpolated or mapped, it may point away from the eye: bend it back to the limit.
  const float facing = glm::dot(normal, wo);
  if (facing < 1e-3f) normal = normalize_or(normal + wo * (1e-3f - facing), geometric);
  return normal;
}

SurfacePoint Tracer::Impl::strand_point(const Geometry& geometry, const mat4x3& world_from_local,
                                        const RTCRayHit& hit, const Ray& ray) const {
  const Curves& curves = *geometry.curves;
  const uint32_t strand = geometry.segment_strand[hit.hit.primID];
  // Segment s of strand i starts at point s + i: each strand has one segment less than points.
  const size_t first = size_t{hit.hit.primID} + strand;
  const vec4 p0 = curves.points[first];
  const vec4 p1 = curves.points[first + 1];
  const vec3 wo = -glm::normalize(ray.direction);
  SurfacePoint point;
  // On the axis: the ribbon that a ray meets turns with the ray (see core/trace/ray_bias.h), and
  // from the vertices the point is exact at any distance.
  const vec3 a = transform_point(world_from_local, vec3(p0));
  const vec3 b = transform_point(world_from_local, vec3(p1));
  point.position = a + (b - a) * hit.hit.u;
  point.geometric_normal = vec3(0);
  point.shading_normal = wo;
  point.tangent =
      normalize_or(transform_vector(world_from_local, vec3(p1) - vec3(p0)), make_frame(wo).tangent);
  const float radius = (p0.w + (p1.w - p0.w) * hit.hit.u) * uniform_scale(world_from_local);
  point.bias = strand_bias(radius);
  point.uv = vec2(hit.hit.u, 0);
  if (!curves.colors.empty()) point.color_scale = curves.colors[strand];
  point.material = curves.materials[strand];
  return point;
}

Tracer::Tracer(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {
  impl_->build();
}
Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;

std::optional<SurfacePoint> Tracer::intersect(const Ray& ray) const {
  RTCRayHit query = make_embree_ray(ray);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->top, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const unsigned instance_id = query.hit.instID[0];
  const Geometry* geometry = nullptr;
  const Instance* instance = nullptr;
  if (instance_id != RTC_INVALID_GEOMETRY_ID) {
    instance = impl_->instance_of[instance_id];
    geometry = impl_->parts[instance->prototype][query.hit.geomID].get();
  } else {
    geometry = impl_->geometries[query.hit.geomID].get();
    instance = geometry->instance;
  }
  const mat4x3& transform = instance->world_from_local;
  SurfacePoint point = geometry->mesh != nullptr
                           ? impl_->mesh_point(*geometry, transform, query, ray)
                           : impl_->strand_point(*geometry, transform, query, ray);
  point.instance = static_cast<uint32_t>(instance - scene().instances.data());
  point.shape = geometry->shape;
  point.primitive = query.hit.primID;
  return point;
}

bool Tracer::occluded(const Ray& ray) const {
  if (!(ray.t_far > ray.t_near)) return false;
  RTCRayHit query = make_embree_ray(ray);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->top, &context, &query.ray);
  return query.ray.tfar < 0;
}

const Scene& Tracer::scene() const {
  return impl_->scene;
}
const TracerStats& Tracer::stats() const {
  return impl_->stats;
}
const Bounds& Tracer::bounds() const {
  return impl_->bounds;
}

}  // namespace relume
