#include "scene/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/internal/cut_outs.h"
#include "scene/internal/nearest_point.h"

namespace pleinair {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Embree computes a hit in single precision, relative to the triangle's corners as seen from the
// ray's origin. For a plane that passes the origin within this share of the mesh's coordinates (64
// rounding errors), it may choose the wrong side. There double precision decides; see Filter.
constexpr float kNearShare = 0x1p-18f;

// Embree's own bound for coordinates. Debian builds it with assertions, which end the program when
// a ray breaks it.
constexpr float kMaxCoordinate = 1.8e18f;

constexpr std::size_t kPacket = 8;

// One device for the process: it holds no state of a query.
RTCDevice SharedDevice() {
  static const RTCDevice device = [] {
    // Without a configuration: threads=1 would limit TBB in the entire process to one thread. The
    // tree, and with it the choice between hits at equal distance, is the same for any number.
    const RTCDevice made = rtcNewDevice(nullptr);
    if (made == nullptr) throw std::runtime_error("ray casting: Embree could not start");
    return made;
  }();
  return device;
}

// Data for Filter, in addition to Embree's own context.
struct Query {
  RTCIntersectContext context;  // First: Embree hands back a pointer to it.
  const glm::vec4* vertices;
  const glm::uvec3* triangles;
  const CutOuts* cut_outs;
  float near_m;
  float max_distance_m;
};

// Distance along the ray to the triangle's plane; not a number where it lies in the plane.
double PlaneDistance(const Query& query,
                     std::uint32_t triangle,
                     const glm::dvec3& origin_m,
                     const glm::dvec3& direction) {
  const glm::uvec3 corners = query.triangles[triangle];
  const glm::dvec3 a(query.vertices[corners.x]);
  const glm::dvec3 normal = glm::cross(glm::dvec3(query.vertices[corners.y]) - a,
                                       glm::dvec3(query.vertices[corners.z]) - a);
  return glm::dot(normal, a - origin_m) / glm::dot(normal, direction);
}

// Whether single precision decides on which side of a hit's plane the ray starts.
bool IsFarFromPlane(const Query& query,
                    const glm::vec3& normal,
                    const glm::vec3& direction,
                    float distance_m) {
  const float height = distance_m * glm::dot(normal, direction);
  return height * height > query.near_m * query.near_m * glm::dot(normal, normal);
}

// Whether the surface really lies in front of the origin. The differences of single-precision
// coordinates are exact in double precision, so the origin's side of a plane is certain. A ray that
// leaves a surface does not meet it again, however large its triangles are.
bool LiesInFront(const Query& query, const RTCFilterFunctionNArguments& arguments, unsigned lane) {
  RTCRayN* const ray = arguments.ray;
  RTCHitN* const hit = arguments.hit;
  const unsigned lanes = arguments.N;
  const glm::vec3 direction(RTCRayN_dir_x(ray, lanes, lane),
                            RTCRayN_dir_y(ray, lanes, lane),
                            RTCRayN_dir_z(ray, lanes, lane));
  const glm::vec3 normal(RTCHitN_Ng_x(hit, lanes, lane),
                         RTCHitN_Ng_y(hit, lanes, lane),
                         RTCHitN_Ng_z(hit, lanes, lane));
  const float distance_m = RTCRayN_tfar(ray, lanes, lane);
  if (IsFarFromPlane(query, normal, direction, distance_m)) {
    return distance_m < query.max_distance_m;
  }
  const glm::dvec3 origin_m(RTCRayN_org_x(ray, lanes, lane),
                            RTCRayN_org_y(ray, lanes, lane),
                            RTCRayN_org_z(ray, lanes, lane));
  const double exact_m =
      PlaneDistance(query, RTCHitN_primID(hit, lanes, lane), origin_m, glm::dvec3(direction));
  return exact_m > 0.0 && exact_m < double{query.max_distance_m};
}

void Filter(const RTCFilterFunctionNArguments* arguments) {
  const Query& query = *reinterpret_cast<const Query*>(arguments->context);
  for (unsigned lane = 0; lane < arguments->N; ++lane) {
    if (arguments->valid[lane] != 0 && !LiesInFront(query, *arguments, lane)) {
      arguments->valid[lane] = 0;
    }
  }
}

// Where triangles are cut out.
void FilterCutOut(const RTCFilterFunctionNArguments* arguments) {
  Filter(arguments);
  const Query& query = *reinterpret_cast<const Query*>(arguments->context);
  for (unsigned lane = 0; lane < arguments->N; ++lane) {
    if (arguments->valid[lane] == 0) continue;
    RTCHitN* const hit = arguments->hit;
    if (!query.cut_outs->IsThere(RTCHitN_primID(hit, arguments->N, lane),
                                 RTCHitN_u(hit, arguments->N, lane),
                                 RTCHitN_v(hit, arguments->N, lane))) {
      arguments->valid[lane] = 0;
    }
  }
}

// Whether Embree takes it. False for what is not a number, too.
bool IsCastable(const glm::vec3& v) {
  return std::abs(v.x) < kMaxCoordinate && std::abs(v.y) < kMaxCoordinate &&
         std::abs(v.z) < kMaxCoordinate;
}

RTCRay NewRay(const glm::vec3& origin_m, const glm::vec3& direction, float max_distance_m) {
  RTCRay ray{};
  ray.org_x = origin_m.x;
  ray.org_y = origin_m.y;
  ray.org_z = origin_m.z;
  ray.dir_x = direction.x;
  ray.dir_y = direction.y;
  ray.dir_z = direction.z;
  ray.tfar = max_distance_m;
  ray.mask = ~0u;
  return ray;
}

// Embree's mask of the lanes that are rays.
struct alignas(32) PacketMask : std::array<int, kPacket> {};

PacketMask FillPacket(const glm::vec3* origins_m,
                      const glm::vec3* directions,
                      std::size_t lanes,
                      RTCRay8& packet) {
  PacketMask valid{};
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const glm::vec3& origin_m = origins_m[lane];
    const glm::vec3& direction = directions[lane];
    if (!IsCastable(origin_m) || !IsCastable(direction)) continue;
    valid[lane] = -1;
    packet.org_x[lane] = origin_m.x;
    packet.org_y[lane] = origin_m.y;
    packet.org_z[lane] = origin_m.z;
    packet.dir_x[lane] = direction.x;
    packet.dir_y[lane] = direction.y;
    packet.dir_z[lane] = direction.z;
    packet.tfar[lane] = kInfinity;
    packet.mask[lane] = ~0u;
  }
  return valid;
}

void TakeHits(const RTCRayHit8& packet,
              const glm::vec3* directions,
              std::size_t lanes,
              FaceHit* hits) {
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    FaceHit& hit = hits[lane];
    hit = {};
    if (packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
    const glm::vec3 normal(packet.hit.Ng_x[lane], packet.hit.Ng_y[lane], packet.hit.Ng_z[lane]);
    hit.triangle = packet.hit.primID[lane];
    hit.is_front = glm::dot(normal, directions[lane]) <= 0.0f;
    hit.distance_m = packet.ray.tfar[lane];
  }
}

}  // namespace

struct RayCaster::Impl {
  RTCScene scene = nullptr;
  const glm::vec4* vertices = nullptr;  // In Embree's own buffers.
  const glm::uvec3* triangles = nullptr;
  float near_m = 0.0f;
  CutOuts cut_outs;

  explicit Impl(const Mesh& mesh) : cut_outs(mesh) {}
  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
  }

  RayHit HitAt(const Query& query,
               std::uint32_t triangle,
               const glm::vec2& barycentric,
               const glm::vec3& origin_m,
               const glm::vec3& direction) const;

  RTCRayHit8 CastPacket(const glm::vec3* origins_m,
                        const glm::vec3* directions,
                        std::size_t lanes,
                        Query& query) const {
    RTCRayHit8 packet{};
    const auto valid = FillPacket(origins_m, directions, lanes, packet.ray);
    std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    CastExactly(valid, query, packet);
    return packet;
  }

  // The nearest hits that Filter accepts. It is called for few rays: what is hit first without it,
  // and far from its plane, is what it would accept, too; other rays are cast again.
  void CastExactly(const PacketMask& valid, Query& query, RTCRayHit8& packet) const {
    if (!cut_outs.Empty()) {
      rtcIntersect8(valid.data(), scene, &query.context, &packet);
      return;
    }
    const RTCFilterFunctionN filter = std::exchange(query.context.filter, nullptr);
    std::array<float, kPacket> farthest_m;
    std::copy_n(packet.ray.tfar, kPacket, farthest_m.begin());
    rtcIntersect8(valid.data(), scene, &query.context, &packet);
    query.context.filter = filter;
    PacketMask again{};
    bool any_again = false;
    for (std::size_t lane = 0; lane < kPacket; ++lane) {
      if (valid[lane] == 0 || packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
      const glm::vec3 normal(packet.hit.Ng_x[lane], packet.hit.Ng_y[lane], packet.hit.Ng_z[lane]);
      const glm::vec3 direction(
          packet.ray.dir_x[lane], packet.ray.dir_y[lane], packet.ray.dir_z[lane]);
      if (IsFarFromPlane(query, normal, direction, packet.ray.tfar[lane])) continue;
      again[lane] = -1;
      any_again = true;
      packet.ray.tfar[lane] = farthest_m[lane];
      packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
    if (any_again) rtcIntersect8(again.data(), scene, &query.context, &packet);
  }

  Query NewQuery(float max_distance_m) const {
    Query query{};
    rtcInitIntersectContext(&query.context);
    query.context.filter = cut_outs.Empty() ? Filter : FilterCutOut;
    query.vertices = vertices;
    query.triangles = triangles;
    query.cut_outs = &cut_outs;
    query.near_m = near_m;
    query.max_distance_m = max_distance_m;
    return query;
  }
};

RayCaster::RayCaster(const Mesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {
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
  rtcSetSceneFlags(
      impl_->scene,
      static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
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
      if (!IsCastable(position_m)) continue;  // Embree leaves its triangles out.
      const glm::vec3 size = glm::abs(position_m);
      largest = std::max({largest, size.x, size.y, size.z});
    }
    std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(impl_->scene, geometry, 0);
    rtcReleaseGeometry(geometry);  // The scene keeps it.
    impl_->vertices = vertices;
    impl_->triangles = triangles;
    impl_->near_m = largest * kNearShare;
  }
  rtcCommitScene(impl_->scene);
}

RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

RayHit RayCaster::Impl::HitAt(const Query& query,
                              std::uint32_t triangle,
                              const glm::vec2& barycentric,
                              const glm::vec3& origin_m,
                              const glm::vec3& direction) const {
  RayHit hit;
  hit.triangle = triangle;
  hit.barycentric = barycentric;
  const glm::uvec3 corners = triangles[triangle];
  const glm::dvec3 a(vertices[corners.x]);
  const glm::dvec3 ab = glm::dvec3(vertices[corners.y]) - a;
  const glm::dvec3 ac = glm::dvec3(vertices[corners.z]) - a;
  const glm::dvec3 position_m = a + double{barycentric.x} * ab + double{barycentric.y} * ac;
  hit.position_m = glm::vec3(position_m);
  hit.geometric_normal = glm::vec3(glm::normalize(glm::cross(ab, ac)));
  const double distance_m =
      PlaneDistance(query, triangle, glm::dvec3(origin_m), glm::dvec3(direction));
  hit.distance_m = std::clamp(static_cast<float>(distance_m),
                              std::numeric_limits<float>::min(),
                              std::nextafter(query.max_distance_m, 0.0f));
  return hit;
}

std::optional<RayHit> RayCaster::Intersect(const glm::vec3& origin_m,
                                           const glm::vec3& direction,
                                           float max_distance_m) const {
  if (!(max_distance_m > 0.0f) || !IsCastable(origin_m) || !IsCastable(direction)) {
    return std::nullopt;
  }
  Query query = impl_->NewQuery(max_distance_m);
  const auto cast = [&] {
    RTCRayHit found{};
    found.ray = NewRay(origin_m, direction, max_distance_m);
    found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl_->scene, &query.context, &found);
    return found;
  };
  const RTCFilterFunctionN filter = query.context.filter;
  // As in CastExactly.
  if (impl_->cut_outs.Empty()) query.context.filter = nullptr;
  RTCRayHit found = cast();
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const glm::vec3 normal(found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z);
  if (query.context.filter == nullptr &&
      !(IsFarFromPlane(query, normal, direction, found.ray.tfar) &&
        found.ray.tfar < max_distance_m)) {
    query.context.filter = filter;
    found = cast();
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  }
  return impl_->HitAt(query, found.hit.primID, {found.hit.u, found.hit.v}, origin_m, direction);
}

void RayCaster::Intersect(const glm::vec3* origins_m,
                          const glm::vec3* directions,
                          std::size_t count,
                          std::optional<RayHit>* hits) const {
  Query query = impl_->NewQuery(kInfinity);
  query.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t begin = 0; begin < count; begin += kPacket) {
    const std::size_t lanes = std::min(kPacket, count - begin);
    const RTCRayHit8 packet =
        impl_->CastPacket(origins_m + begin, directions + begin, lanes, query);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      hits[begin + lane].reset();
      if (packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) continue;
      hits[begin + lane] = impl_->HitAt(query,
                                        packet.hit.primID[lane],
                                        {packet.hit.u[lane], packet.hit.v[lane]},
                                        origins_m[begin + lane],
                                        directions[begin + lane]);
    }
  }
}

void RayCaster::Intersect(const glm::vec3* origins_m,
                          const glm::vec3* directions,
                          std::size_t count,
                          FaceHit* hits) const {
  Query query = impl_->NewQuery(kInfinity);
  for (std::size_t begin = 0; begin < count; begin += kPacket) {
    const std::size_t lanes = std::min(kPacket, count - begin);
    const RTCRayHit8 packet =
        impl_->CastPacket(origins_m + begin, directions + begin, lanes, query);
    TakeHits(packet, directions + begin, lanes, hits + begin);
  }
}

void RayCaster::IntersectNearer(const glm::vec3* origins_m,
                                const glm::vec3* directions,
                                std::size_t count,
                                FaceHit* hits) const {
  Query query = impl_->NewQuery(kInfinity);
  for (std::size_t begin = 0; begin < count; begin += kPacket) {
    const std::size_t lanes = std::min(kPacket, count - begin);
    RTCRayHit8 packet{};
    const auto valid = FillPacket(origins_m + begin, directions + begin, lanes, packet.ray);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      packet.ray.tfar[lane] = hits[begin + lane].distance_m;
    }
    std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    impl_->CastExactly(valid, query, packet);
    std::array<FaceHit, kPacket> found;
    TakeHits(packet, directions + begin, lanes, found.data());
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      FaceHit& hit = hits[begin + lane];
      if (found[lane].distance_m < hit.distance_m) {
        hit = found[lane];
      } else {
        hit.triangle = FaceHit::kNone;
      }
    }
  }
}

void RayCaster::IntersectFrom(const glm::vec3& origin_m,
                              Origin where,
                              const glm::vec3* directions,
                              std::size_t count,
                              FaceHit* hits) const {
  if (!IsCastable(origin_m)) {
    std::fill_n(hits, count, FaceHit{});
    return;
  }
  Query query = impl_->NewQuery(kInfinity);
  const bool is_exact = where == Origin::kMayBeOnMesh || !impl_->cut_outs.Empty();
  if (!is_exact) query.context.filter = nullptr;
  RTCRayHit8 packet{};
  std::fill_n(packet.ray.org_x, kPacket, origin_m.x);
  std::fill_n(packet.ray.org_y, kPacket, origin_m.y);
  std::fill_n(packet.ray.org_z, kPacket, origin_m.z);
  std::fill_n(packet.ray.mask, kPacket, ~0u);
  for (std::size_t begin = 0; begin < count; begin += kPacket) {
    const std::size_t lanes = std::min(kPacket, count - begin);
    PacketMask valid{};
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const glm::vec3& direction = directions[begin + lane];
      valid[lane] = IsCastable(direction) ? -1 : 0;
      packet.ray.dir_x[lane] = direction.x;
      packet.ray.dir_y[lane] = direction.y;
      packet.ray.dir_z[lane] = direction.z;
    }
    std::fill_n(packet.ray.tfar, kPacket, kInfinity);
    std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    // Not as coherent rays: Embree's way with those is the slower one over an object's small
    // triangles.
    if (is_exact) {
      impl_->CastExactly(valid, query, packet);
    } else {
      rtcIntersect8(valid.data(), impl_->scene, &query.context, &packet);
    }
    TakeHits(packet, directions + begin, lanes, hits + begin);
  }
}

float RayCaster::DistanceTo(const glm::vec3& point_m, float within_m) const {
  if (impl_->vertices == nullptr || !IsCastable(point_m) || !(within_m > 0.0f)) return within_m;
  return NearestDistanceM(impl_->scene, impl_->vertices, impl_->triangles, point_m, within_m);
}

bool RayCaster::Occluded(const glm::vec3& origin_m,
                         const glm::vec3& direction,
                         float max_distance_m) const {
  if (!(max_distance_m > 0.0f) || !IsCastable(origin_m) || !IsCastable(direction)) return false;
  Query query = impl_->NewQuery(max_distance_m);
  RTCRay ray = NewRay(origin_m, direction, max_distance_m);
  rtcOccluded1(impl_->scene, &query.context, &ray);
  return ray.tfar < 0.0f;  // Embree's mark of an occluded ray.
}

void RayCaster::Occluded(const glm::vec3* origins_m,
                         const glm::vec3* directions,
                         std::size_t count,
                         bool* occluded) const {
  Query query = impl_->NewQuery(kInfinity);
  query.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t begin = 0; begin < count; begin += kPacket) {
    const std::size_t lanes = std::min(kPacket, count - begin);
    RTCRay8 packet{};
    const auto valid = FillPacket(origins_m + begin, directions + begin, lanes, packet);
    rtcOccluded8(valid.data(), impl_->scene, &query.context, &packet);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      occluded[begin + lane] = packet.tfar[lane] < 0.0f;
    }
  }
}

// A hit point is the true one rounded to float: each coordinate is off by half a unit in the last
// place, 2^-24 of its size. The moved point's is rounded again. Along a unit normal that is at most
// 2 sqrt(3) 2^-24 = 2^-22.2 of the largest coordinate. Twice that leaves the point on its side, and
// RayCaster needs no more.
glm::vec3 OffsetFromSurface(const glm::vec3& position_m, const glm::vec3& normal_to_side) {
  constexpr double kOffsetShare = 0x1p-21;
  const glm::dvec3 size = glm::abs(glm::dvec3(position_m));
  const double distance_m = kOffsetShare * std::max({size.x, size.y, size.z});
  return glm::vec3(glm::dvec3(position_m) + distance_m * glm::dvec3(normal_to_side));
}

}  // namespace pleinair
