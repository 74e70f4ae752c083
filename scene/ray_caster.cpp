#include "scene/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Embree works out a hit in single precision, relative to the triangle's corners as seen from the
// ray's origin; what it says of a surface nearer than this share of the mesh's coordinates (64
// rounding errors) may be wrong by sign. There the plane in double precision decides; see Filter.
constexpr float kNearShare = 0x1p-18f;

constexpr std::size_t kPacket = 8;

// One device for the process: it holds no state of a query.
RTCDevice SharedDevice() {
  static const RTCDevice device = [] {
    // One thread: the build's order, and with it the choice between hits at equal distance, does
    // not depend on the machine.
    const RTCDevice made = rtcNewDevice("threads=1");
    if (made == nullptr) throw std::runtime_error("ray casting: Embree could not start");
    return made;
  }();
  return device;
}

// The rays as asked for, beside Embree's own context: what Embree sees starts a little earlier.
struct Query {
  RTCIntersectContext context;  // First: Embree hands back a pointer to it.
  const glm::vec3* origins_m;
  const glm::vec3* directions;
  float max_distance_m;
  const glm::vec4* vertices;
  const glm::uvec3* triangles;
};

// Distance along the ray to the triangle's plane; not a number where it lies in the plane.
double PlaneDistance(const Query& query, std::uint32_t triangle, std::uint32_t ray) {
  const glm::uvec3 corners = query.triangles[triangle];
  const glm::dvec3 a(query.vertices[corners.x]);
  const glm::dvec3 normal = glm::cross(glm::dvec3(query.vertices[corners.y]) - a,
                                       glm::dvec3(query.vertices[corners.z]) - a);
  const glm::dvec3 origin(query.origins_m[ray]);
  return glm::dot(normal, a - origin) / glm::dot(normal, glm::dvec3(query.directions[ray]));
}

// Keeps the hits in front of the true origin. The differences of single-precision coordinates are
// exact in double precision, so the side of the plane on which the origin lies is known for sure.
void Filter(const RTCFilterFunctionNArguments* arguments) {
  const Query& query = *reinterpret_cast<const Query*>(arguments->context);
  for (unsigned lane = 0; lane < arguments->N; ++lane) {
    if (arguments->valid[lane] == 0) continue;
    const std::uint32_t triangle = RTCHitN_primID(arguments->hit, arguments->N, lane);
    const std::uint32_t ray = RTCRayN_id(arguments->ray, arguments->N, lane);
    const double distance = PlaneDistance(query, triangle, ray);
    if (!(distance > 0.0 && distance < query.max_distance_m)) arguments->valid[lane] = 0;
  }
}

}  // namespace

struct RayCaster::Impl {
  RTCScene scene = nullptr;
  const glm::vec4* vertices = nullptr;  // In Embree's own buffers.
  const glm::uvec3* triangles = nullptr;
  float step_back_m = 0.0f;

  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
  }

  Query NewQuery(const glm::vec3* origins_m,
                 const glm::vec3* directions,
                 float max_distance_m) const {
    Query query{};
    rtcInitIntersectContext(&query.context);
    query.origins_m = origins_m;
    query.directions = directions;
    query.max_distance_m = max_distance_m;
    query.vertices = vertices;
    query.triangles = triangles;
    return query;
  }

  RTCRay NewRay(const glm::vec3& origin_m,
                const glm::vec3& direction,
                float max_distance_m,
                unsigned id) const {
    const glm::vec3 start_m = origin_m - step_back_m * direction;
    RTCRay ray{};
    ray.org_x = start_m.x;
    ray.org_y = start_m.y;
    ray.org_z = start_m.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tnear = 0.0f;
    // Far enough to hold max_distance_m whatever the rounding: Filter draws the line.
    ray.tfar = max_distance_m * (1.0f + 0x1p-20f) + 2.0f * step_back_m;
    ray.mask = ~0u;
    ray.id = id;
    return ray;
  }
};

RayCaster::RayCaster(const Mesh& mesh) : impl_(std::make_unique<Impl>()) {
  for (const glm::uvec3& triangle : mesh.triangles) {
    const std::uint32_t highest = std::max({triangle.x, triangle.y, triangle.z});
    if (highest >= mesh.positions_m.size()) {
      throw std::invalid_argument("ray casting: triangle corner " + std::to_string(highest) +
                                  " of a mesh with " + std::to_string(mesh.positions_m.size()) +
                                  " vertices");
    }
  }
  const RTCDevice device = SharedDevice();
  impl_->scene = rtcNewScene(device);
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(impl_->scene, RTC_BUILD_QUALITY_HIGH);
  if (!mesh.Empty()) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<glm::vec4*>(rtcSetNewGeometryBuffer(geometry,
                                                                     RTC_BUFFER_TYPE_VERTEX,
                                                                     0,
                                                                     RTC_FORMAT_FLOAT3,
                                                                     sizeof(glm::vec4),
                                                                     mesh.positions_m.size()));
    auto* triangles = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(geometry,
                                                                       RTC_BUFFER_TYPE_INDEX,
                                                                       0,
                                                                       RTC_FORMAT_UINT3,
                                                                       sizeof(glm::uvec3),
                                                                       mesh.triangles.size()));
    if (vertices == nullptr || triangles == nullptr) {
      rtcReleaseGeometry(geometry);
      throw std::runtime_error("ray casting: not enough memory for " +
                               std::to_string(mesh.triangles.size()) + " triangles");
    }
    float largest = 0.0f;
    for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
      const glm::vec3& position_m = mesh.positions_m[i];
      vertices[i] = glm::vec4(position_m, 0.0f);
      for (int axis = 0; axis < 3; ++axis) {
        if (std::isfinite(position_m[axis]))
          largest = std::max(largest, std::abs(position_m[axis]));
      }
    }
    std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
    rtcSetGeometryIntersectFilterFunction(geometry, Filter);
    rtcSetGeometryOccludedFilterFunction(geometry, Filter);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(impl_->scene, geometry, 0);
    rtcReleaseGeometry(geometry);  // The scene keeps it.
    impl_->vertices = vertices;
    impl_->triangles = triangles;
    impl_->step_back_m = largest * kNearShare;
  }
  rtcCommitScene(impl_->scene);
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<RayHit> RayCaster::Intersect(const glm::vec3& origin_m,
                                           const glm::vec3& direction,
                                           float max_distance_m) const {
  if (!(max_distance_m > 0.0f)) return std::nullopt;
  Query query = impl_->NewQuery(&origin_m, &direction, max_distance_m);
  RTCRayHit found{};
  found.ray = impl_->NewRay(origin_m, direction, max_distance_m, 0);
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &query.context, &found);
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  RayHit hit;
  hit.triangle = found.hit.primID;
  hit.barycentric = {found.hit.u, found.hit.v};
  const glm::uvec3 corners = impl_->triangles[hit.triangle];
  const glm::dvec3 a(impl_->vertices[corners.x]);
  const glm::dvec3 ab = glm::dvec3(impl_->vertices[corners.y]) - a;
  const glm::dvec3 ac = glm::dvec3(impl_->vertices[corners.z]) - a;
  const glm::dvec3 position_m = a + double{found.hit.u} * ab + double{found.hit.v} * ac;
  hit.position_m = glm::vec3(position_m);
  hit.geometric_normal = glm::vec3(glm::normalize(glm::cross(ab, ac)));
  hit.distance_m = static_cast<float>(PlaneDistance(query, hit.triangle, 0));
  return hit;
}

bool RayCaster::Occluded(const glm::vec3& origin_m,
                         const glm::vec3& direction,
                         float max_distance_m) const {
  if (!(max_distance_m > 0.0f)) return false;
  Query query = impl_->NewQuery(&origin_m, &direction, max_distance_m);
  RTCRay ray = impl_->NewRay(origin_m, direction, max_distance_m, 0);
  rtcOccluded1(impl_->scene, &query.context, &ray);
  return ray.tfar < 0.0f;  // Embree's mark of an occluded ray.
}

void RayCaster::Occluded(const glm::vec3* origins_m,
                         const glm::vec3* directions,
                         std::size_t count,
                         bool* occluded) const {
  for (std::size_t begin = 0; begin < count; begin += kPacket) {
    const std::size_t lanes = std::min(kPacket, count - begin);
    Query query = impl_->NewQuery(origins_m + begin, directions + begin, kInfinity);
    RTCRay8 packet{};
    alignas(32) std::array<int, kPacket> valid{};
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const RTCRay ray = impl_->NewRay(origins_m[begin + lane],
                                       directions[begin + lane],
                                       kInfinity,
                                       static_cast<unsigned>(lane));
      valid[lane] = -1;
      packet.org_x[lane] = ray.org_x;
      packet.org_y[lane] = ray.org_y;
      packet.org_z[lane] = ray.org_z;
      packet.dir_x[lane] = ray.dir_x;
      packet.dir_y[lane] = ray.dir_y;
      packet.dir_z[lane] = ray.dir_z;
      packet.tnear[lane] = ray.tnear;
      packet.tfar[lane] = ray.tfar;
      packet.mask[lane] = ray.mask;
      packet.id[lane] = ray.id;
    }
    query.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded8(valid.data(), impl_->scene, &query.context, &packet);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      occluded[begin + lane] = packet.tfar[lane] < 0.0f;
    }
  }
}

// A hit point is the true one rounded to float: each coordinate is off by half a unit in the last
// place, 2^-24 of its size, and so is the moved one. The plane's distance to both is at most
// dot(|n|, 2^-24 (2 |p| + |step|)). Twice that leaves the point on its side; RayCaster's decision
// in double precision needs no more.
glm::vec3 OffsetFromSurface(const glm::vec3& position_m, const glm::vec3& normal_to_side) {
  constexpr double kOffsetShare = 0x1p-22;
  const glm::dvec3 position(position_m);
  const glm::dvec3 normal(normal_to_side);
  const double distance = kOffsetShare * glm::dot(glm::abs(normal), glm::abs(position));
  return glm::vec3(position + distance * normal);
}

}  // namespace pleinair
