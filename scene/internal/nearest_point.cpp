#include "scene/internal/nearest_point.h"

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// The nearest point of a triangle to `point_m` (Ericson, Real-Time Collision Detection, 5.1.5); not
// a number where the triangle has no area.
glm::vec3 NearestOnTriangle(const glm::vec3& point_m,
                            const glm::vec3& a_m,
                            const glm::vec3& b_m,
                            const glm::vec3& c_m) {
  const glm::vec3 ab = b_m - a_m;
  const glm::vec3 ac = c_m - a_m;
  const glm::vec3 from_a = point_m - a_m;
  const float d1 = glm::dot(ab, from_a);
  const float d2 = glm::dot(ac, from_a);
  if (d1 <= 0.0f && d2 <= 0.0f) return a_m;
  const glm::vec3 from_b = point_m - b_m;
  const float d3 = glm::dot(ab, from_b);
  const float d4 = glm::dot(ac, from_b);
  if (d3 >= 0.0f && d4 <= d3) return b_m;
  const float of_c = d1 * d4 - d3 * d2;
  if (of_c <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return a_m + d1 / (d1 - d3) * ab;
  const glm::vec3 from_c = point_m - c_m;
  const float d5 = glm::dot(ab, from_c);
  const float d6 = glm::dot(ac, from_c);
  if (d6 >= 0.0f && d5 <= d6) return c_m;
  const float of_b = d5 * d2 - d1 * d6;
  if (of_b <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return a_m + d2 / (d2 - d6) * ac;
  const float of_a = d3 * d6 - d5 * d4;
  if (of_a <= 0.0f && d4 >= d3 && d5 >= d6) {
    return b_m + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c_m - b_m);
  }
  const float sum = of_a + of_b + of_c;
  return a_m + of_b / sum * ab + of_c / sum * ac;
}

struct NearestQuery {
  const glm::vec4* vertices;
  const glm::uvec3* triangles;
  glm::vec3 point_m;
};

// Embree's visit of a triangle that may be nearer: whether it has made the search's radius less.
bool VisitNearest(RTCPointQueryFunctionArguments* arguments) {
  const auto& nearest = *static_cast<const NearestQuery*>(arguments->userPtr);
  const glm::uvec3 corners = nearest.triangles[arguments->primID];
  const float distance_m = glm::distance(nearest.point_m,
                                         NearestOnTriangle(nearest.point_m,
                                                           glm::vec3(nearest.vertices[corners.x]),
                                                           glm::vec3(nearest.vertices[corners.y]),
                                                           glm::vec3(nearest.vertices[corners.z])));
  if (!(distance_m < arguments->query->radius)) return false;
  arguments->query->radius = distance_m;
  return true;
}

}  // namespace

float NearestDistanceM(RTCScene scene,
                       const glm::vec4* vertices,
                       const glm::uvec3* triangles,
                       const glm::vec3& point_m,
                       float within_m) {
  NearestQuery nearest{vertices, triangles, point_m};
  RTCPointQuery query{};
  query.x = point_m.x;
  query.y = point_m.y;
  query.z = point_m.z;
  query.radius = within_m;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &query, &context, VisitNearest, &nearest);
  return query.radius;
}

}  // namespace pleinair
