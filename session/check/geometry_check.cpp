#include "session/check/geometry_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// Usual sizes at sites, in metres: courtyards to valleys, cameras on stands to drones, cups to
// houses.
struct UsualSize {
  double least_m;
  double most_m;
};
constexpr UsualSize kMeshLength{2.0, 3000.0};
constexpr UsualSize kMeshHeight{0.0, 300.0};  // A mesh of level ground only has none.
constexpr UsualSize kCameraHeight{0.1, 120.0};
constexpr UsualSize kObjectLength{0.03, 60.0};

// "centimetres" where these make of a length something usual.
const char* UnitOf(double length, UsualSize usual) {
  struct Unit {
    const char* name;
    double metres;
  };
  for (const Unit unit :
       {Unit{"centimetres", 0.01}, Unit{"millimetres", 0.001}, Unit{"kilometres", 1000.0}}) {
    const double metres = length * unit.metres;
    // Well inside, so that the first that fits is the likeliest.
    if (metres >= 2.0 * usual.least_m && metres <= 0.1 * usual.most_m) return unit.name;
  }
  return "another unit";
}

bool IsUsual(double length_m, UsualSize usual) {
  return length_m >= usual.least_m && length_m <= usual.most_m;
}

std::string RangeText(UsualSize usual) {
  return fmt::format("{:g} to {:g} m", usual.least_m, usual.most_m);
}

double LongestSide(const BoundingBox& box) {
  const glm::vec3 size = box.upper_m - box.lower_m;
  return std::max({size.x, size.y, size.z});
}

std::optional<double> HeightOverMesh(const glm::dvec3& point_m, const RayCaster& caster) {
  const auto hit = caster.Intersect(glm::vec3(point_m), glm::vec3(0.0f, 0.0f, -1.0f));
  if (!hit) return std::nullopt;
  return hit->distance_m;
}

constexpr std::array<glm::vec3, 6> kAxes{glm::vec3{0, 0, 1},
                                         glm::vec3{0, 0, -1},
                                         glm::vec3{0, 1, 0},
                                         glm::vec3{0, -1, 0},
                                         glm::vec3{1, 0, 0},
                                         glm::vec3{-1, 0, 0}};
constexpr std::array<const char*, 6> kAxisNames{"+Z", "-Z", "+Y", "-Y", "+X", "-X"};

// For points spread through the mesh's box, per axis: the share with nothing in that direction, and
// a surface that faces it in the opposite one. Outdoors up is such an axis.
std::array<double, 6> OpennessOf(const Mesh& mesh, const RayCaster& caster) {
  constexpr int kSteps = 7;
  // Share of the longest side: a mesh of level ground only is flat.
  constexpr float kLeastShare = 0.1f;
  const BoundingBox box = BoundingBoxOf(mesh);
  const glm::vec3 middle = 0.5f * (box.lower_m + box.upper_m);
  const auto least = static_cast<float>(kLeastShare * LongestSide(box));
  const glm::vec3 half = glm::max(0.5f * (box.upper_m - box.lower_m), glm::vec3(least));
  std::array<double, 6> open{};
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const glm::vec3 step(i % kSteps, i / kSteps % kSteps, i / (kSteps * kSteps));
    const glm::vec3 point = middle + half * (2.0f * (step + 0.5f) / float(kSteps) - 1.0f);
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      const glm::vec3& up = kAxes[axis];
      if (caster.Occluded(point, up)) continue;
      const auto below = caster.Intersect(point, -up);
      constexpr float kFacing = 0.9f;
      if (below && std::abs(glm::dot(below->geometric_normal, up)) > kFacing) open[axis] += 1.0;
    }
  }
  for (double& share : open) share /= kSteps * kSteps * kSteps;
  return open;
}

// Share of a mesh's area whose normal is along none but `axis`: walls, where that is up.
double ShareAcross(const Mesh& mesh, const glm::vec3& axis) {
  double across = 0.0;
  double all = 0.0;
  for (const glm::uvec3& corners : mesh.triangles) {
    const glm::vec3& a = mesh.positions_m[corners.x];
    const glm::vec3 twice_area =
        glm::cross(mesh.positions_m[corners.y] - a, mesh.positions_m[corners.z] - a);
    const double area = glm::length(twice_area);
    all += area;
    if (std::abs(glm::dot(twice_area, axis)) < 0.3 * area) across += area;
  }
  return all > 0.0 ? across / all : 0.0;
}

// Share of the picture in which `camera` sees the mesh.
double ShareSeen(const Camera& camera, const RayCaster& caster) {
  constexpr int kColumns = 24;
  constexpr int kRows = 18;
  const Lens lens(camera.intrinsics);
  const glm::vec3 centre(camera.CentreWorldM());
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  int seen = 0;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const glm::dvec2 pixel((x + 0.5) / kColumns * camera.intrinsics.width_px - 0.5,
                             (y + 0.5) / kRows * camera.intrinsics.height_px - 0.5);
      const auto along = lens.DirectionFromPixel(pixel);
      if (along && caster.Occluded(centre, glm::vec3(glm::normalize(world_from_camera * *along)))) {
        ++seen;
      }
    }
  }
  return double(seen) / (kColumns * kRows);
}

// Poses that people write by mistake, with what each would have to be.
struct PoseReading {
  const char* what;
  glm::dmat4 camera_from_world;
};

std::vector<PoseReading> OtherReadings(const glm::dmat4& written) {
  glm::dmat4 gl_axes(1.0);  // x right, y up, z backward.
  gl_axes[1][1] = gl_axes[2][2] = -1.0;
  glm::dmat4 y_up(1.0);  // World: x east, y up, z south.
  y_up[1] = {0.0, 0.0, -1.0, 0.0};
  y_up[2] = {0.0, 1.0, 0.0, 0.0};
  return {{"world_from_camera", glm::inverse(written)},
          {"OpenGL's camera axes (y up, z backward)", gl_axes * written},
          {"world_from_camera in OpenGL's camera axes", gl_axes * glm::inverse(written)},
          {"a world with Y up", written * y_up}};
}

// How much of a window's polygon the mesh covers, within a wall's thickness, and with which group
// most.
struct WindowCover {
  double share = 0.0;
  std::string group;
};

WindowCover CoverOf(const std::vector<glm::dvec3>& polygon_m,
                    const Mesh& mesh,
                    const RayCaster& caster) {
  constexpr double kHalfDepthM = 0.1;
  constexpr int kPlaces = 64;  // Of each triangle around the middle.
  glm::dvec3 middle_m(0.0);
  for (const glm::dvec3& corner_m : polygon_m) middle_m += corner_m;
  middle_m /= static_cast<double>(polygon_m.size());
  double area = 0.0;
  double covered = 0.0;
  std::map<std::string, double> of_group;
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const glm::dvec3 a = polygon_m[i] - middle_m;
    const glm::dvec3 b = polygon_m[(i + 1) % polygon_m.size()] - middle_m;
    const glm::dvec3 across = glm::cross(a, b);
    if (!(glm::length(across) > 0.0)) continue;
    const glm::dvec3 normal = glm::normalize(across);
    const double part = glm::length(across) / kPlaces;
    for (int place = 0; place < kPlaces; ++place) {
      glm::dvec2 at = FibonacciPoint(place, kPlaces, glm::dvec2(0.5 / kPlaces, 0.0));
      if (at.x + at.y > 1.0) at = 1.0 - at;
      const glm::dvec3 start_m = middle_m + at.x * a + at.y * b - kHalfDepthM * normal;
      const auto hit = caster.Intersect(glm::vec3(start_m), glm::vec3(normal));
      area += part;
      if (!hit || hit->distance_m > 2.0 * kHalfDepthM) continue;
      covered += part;
      of_group[mesh.group_names[mesh.triangle_group[hit->triangle]]] += part;
    }
  }
  if (!(covered > 0.0)) return {};
  const auto most = std::ranges::max_element(
      of_group, {}, [](const std::pair<const std::string, double>& one) { return one.second; });
  return {covered / area, most->first};
}

// Whether light of the sky gets to a place, by some reflections.
bool GetsSky(const glm::vec3& place_m, const RayCaster& caster) {
  constexpr int kWalks = 1024;
  constexpr int kReflections = 6;  // Through a second room.
  std::uint64_t random = 1;
  const auto uniform = [&] { return UnitFromHash(random = HashBits(random)); };
  for (int walk = 0; walk < kWalks; ++walk) {
    glm::vec3 start_m = place_m;
    glm::vec3 normal(0.0f, 0.0f, walk % 2 == 0 ? 1.0f : -1.0f);
    for (int reflection = 0; reflection <= kReflections; ++reflection) {
      const double first = uniform();
      const glm::vec3 direction = NormalFrame(normal).CosineDirection({first, uniform()});
      const auto hit = caster.Intersect(start_m, direction);
      if (!hit && direction.z > 0.0f) return true;
      if (!hit) break;
      const bool is_front = glm::dot(hit->geometric_normal, direction) < 0.0f;
      normal = is_front ? hit->geometric_normal : -hit->geometric_normal;
      start_m = OffsetFromSurface(hit->position_m, normal);
    }
  }
  return false;
}

}  // namespace

SiteWarnings CheckUnits(const Sequence& sequence,
                        const Mesh& mesh,
                        const RayCaster& caster,
                        std::span<const VirtualObject> objects,
                        std::span<const ObjectMotion> motions) {
  SiteWarnings warnings;
  const std::string file = sequence.scene_mesh.string();
  const BoundingBox box = BoundingBoxOf(mesh);
  const double length = LongestSide(box);
  const double height = box.upper_m.z - box.lower_m.z;
  if (!IsUsual(length, kMeshLength) || !IsUsual(height, kMeshHeight)) {
    warnings.push_back(
        {"the mesh seems not to be in metres",
         file,
         fmt::format("it would be {:.4g} m long and {:.4g} m high; sites are {} and up to {:g} m "
                     "high",
                     length,
                     height,
                     RangeText(kMeshLength),
                     kMeshHeight.most_m),
         fmt::format("if it is in {}, convert it: pleinair site new {} --mesh FILE --mesh-units "
                     "cm|mm|ft",
                     UnitOf(length, kMeshLength),
                     sequence.folder.string()),
         true});
  }
  const glm::dvec3 centre = sequence.CameraOfFrame(0).CentreWorldM();
  const auto over_ground = HeightOverMesh(centre, caster);
  if (over_ground && !IsUsual(*over_ground, kCameraHeight)) {
    warnings.push_back(
        {"the camera's place seems not to be in the mesh's unit",
         "camera_from_world",
         fmt::format("the camera would stand {:.4g} m over the surface beneath it; cameras stand "
                     "{} over theirs",
                     *over_ground,
                     RangeText(kCameraHeight)),
         "write the translation of camera_from_world in metres, as the mesh",
         true});
  }
  // Each with all of its parts.
  std::map<std::size_t, BoundingBox> boxes;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const BoundingBox part = BoundingBoxOf(objects[i].mesh);
    BoundingBox& all = boxes.try_emplace(motions[i].entry, part).first->second;
    all.lower_m = glm::min(all.lower_m, part.lower_m);
    all.upper_m = glm::max(all.upper_m, part.upper_m);
  }
  std::set<std::string> said;  // A file that is placed several times is one mistake.
  for (const auto& [entry, object] : boxes) {
    const double size = LongestSide(object);
    if (IsUsual(size, kObjectLength)) continue;
    const std::string name = sequence.virtual_objects[entry].mesh.string();
    if (!said.insert(name).second) continue;
    warnings.push_back(
        {"the virtual object seems not to be in metres",
         name,
         fmt::format(
             "as placed it is {:.4g} m long; objects are {}", size, RangeText(kObjectLength)),
         fmt::format("if its file is in {}, scale world_from_object, or: pleinair site new {} "
                     "--object FILE --object-units cm|mm|ft",
                     UnitOf(size, kObjectLength),
                     sequence.folder.string())});
  }
  return warnings;
}

SiteWarnings CheckAxes(const Sequence& sequence, const Mesh& mesh, const RayCaster& caster) {
  SiteWarnings warnings;
  constexpr double kClearlyOpen = 0.2;
  constexpr double kMostAsStated = 0.3;  // Share of that.
  constexpr double kLeastWalls = 0.001;  // A façade alone faces nothing but its street.
  const std::array<double, 6> open = OpennessOf(mesh, caster);
  const auto best =
      static_cast<std::size_t>(std::max_element(open.begin(), open.end()) - open.begin());
  const bool mesh_is_turned = open[best] >= kClearlyOpen && open[0] < kMostAsStated * open[best] &&
                              ShareAcross(mesh, kAxes[best]) >= kLeastWalls;
  if (mesh_is_turned) {
    warnings.push_back(
        {fmt::format("the mesh's up seems to be {}, not +Z", kAxisNames[best]),
         sequence.scene_mesh.string(),
         fmt::format("from {:.0f} % of places in it the way to {} is open with a surface on the "
                     "other side, as between ground and sky; along +Z from {:.0f} %",
                     100.0 * open[best],
                     kAxisNames[best],
                     100.0 * open[0]),
         best == 2 ? fmt::format("turn it to east, north, up: pleinair site new {} --mesh FILE "
                                 "--mesh-up y",
                                 sequence.folder.string())
                   : std::string("turn it to east (+X), north (+Y), up (+Z)"),
         true});
  }
  return warnings;
}

SiteWarnings CheckPose(const Sequence& sequence, const RayCaster& caster) {
  SiteWarnings warnings;
  const Camera camera = sequence.CameraOfFrame(0);
  constexpr double kLeastSeen = 0.1;
  constexpr double kHardlySeen = 0.01;
  const double seen = ShareSeen(camera, caster);
  // Image rows go down.
  const double image_up_z = -camera.camera_from_world[2][1];
  constexpr double kHangingDown = -0.5;
  if (seen < kLeastSeen || image_up_z < kHangingDown) {
    std::string evidence =
        seen < kLeastSeen
            ? fmt::format("the camera sees the mesh in {:.0f} % of the picture", 100.0 * seen)
            : std::string("the top of the picture points to the ground");
    std::string reading;
    double best_score = 0.0;
    for (const PoseReading& other : OtherReadings(camera.camera_from_world)) {
      const glm::dmat4& pose = other.camera_from_world;
      const double share = ShareSeen({camera.intrinsics, pose}, caster);
      // Upright and level, as pictures mostly are.
      const double score = share * -pose[2][1] * (1.0 - std::abs(pose[2][0]));
      constexpr double kLeastSeenRight = 0.3;
      if (share < kLeastSeenRight || !(score > best_score)) continue;
      best_score = score;
      reading = fmt::format("; read as {}, it sees it in {:.0f} %", other.what, 100.0 * share);
    }
    evidence += reading;
    warnings.push_back({"the camera's pose does not look at the mesh, or is upside down",
                        "camera_from_world",
                        evidence,
                        "expected is camera_from_world, row by row: camera x right, y down, z "
                        "forward (OpenCV); world +X east, +Y north, +Z up, metres",
                        !reading.empty() || seen < kHardlySeen});
  }
  return warnings;
}

SiteWarnings CheckPlaces(const Sequence& sequence, const RayCaster& caster) {
  SiteWarnings warnings;
  // The first frame's pose is CheckAxes's.
  std::optional<std::size_t> first;
  int frames = 0;
  for (std::size_t i = 1; i < sequence.frames.size(); ++i) {
    if (!sequence.frames[i].camera_from_world) continue;
    constexpr double kNearlyNothing = 0.01;
    if (!(ShareSeen(sequence.CameraOfFrame(i), caster) < kNearlyNothing)) continue;
    if (!first) first = i;
    ++frames;
  }
  if (first) {
    const glm::dvec3 at_m = sequence.CameraOfFrame(*first).CentreWorldM();
    warnings.push_back(
        {fmt::format("frames that do not show the mesh: {}", frames),
         fmt::format("frames[{}].camera_from_world", *first),
         fmt::format("from ({:.1f}, {:.1f}, {:.1f}) m the camera sees it in less than 1 % of the "
                     "picture: hardly any light is measured there",
                     at_m.x,
                     at_m.y,
                     at_m.z),
         "correct the poses, or leave these frames out"});
  }
  if (!sequence.environment) return warnings;
  const glm::dvec3& map_m = sequence.environment->position_m;
  constexpr int kDirections = 4096;
  constexpr double kSteep = 0.7;  // Sine of the elevation.
  int seen = 0;
  int steep = 0;  // Upwards, and as many downwards.
  int steep_above = 0;
  int steep_below = 0;
  for (int i = 0; i < kDirections; ++i) {
    const glm::dvec2 point = FibonacciPoint(i, kDirections, glm::dvec2(0.0));
    const double z = 1.0 - 2.0 * point.x;
    const double turn = 2.0 * std::numbers::pi * point.y;
    const double across = std::sqrt(std::max(0.0, 1.0 - z * z));
    const glm::vec3 direction(across * std::cos(turn), across * std::sin(turn), z);
    const bool is_mesh = caster.Occluded(glm::vec3(map_m), direction);
    seen += is_mesh ? 1 : 0;
    steep += z > kSteep ? 1 : 0;
    steep_above += is_mesh && z > kSteep ? 1 : 0;
    steep_below += is_mesh && z < -kSteep ? 1 : 0;
  }
  constexpr double kLeastSeenAround = 0.001;
  constexpr double kMost = 0.9;
  const bool is_far = seen < kLeastSeenAround * kDirections;
  // All above and nothing below: the ground from beneath.
  const bool is_below = steep_above > kMost * steep && steep_below < (1.0 - kMost) * steep;
  if (!is_far && !is_below) return warnings;
  warnings.push_back(
      {is_far ? "the environment map was taken where hardly anything of the mesh is seen"
              : "the environment map was taken below the ground",
       "environment.position_m",
       fmt::format(
           "around ({:.1f}, {:.1f}, {:.1f}) m the mesh is in {:.1f} % of all directions, in "
           "{:.0f} % of those steeply up, and in {:.0f} % of those steeply down",
           map_m.x,
           map_m.y,
           map_m.z,
           100.0 * seen / kDirections,
           100.0 * steep_above / steep,
           100.0 * steep_below / steep),
       "state where the panorama's camera stood, in the mesh's metres"});
  return warnings;
}

SiteWarnings CheckFramePoses(const Sequence& sequence) {
  const std::vector<FrameEntry>& frames = sequence.frames;
  const auto has_none = [](const FrameEntry& frame) { return !frame.camera_from_world; };
  const auto without = std::ranges::count_if(frames, has_none);
  if (without == 0 || without == std::ssize(frames)) return {};
  const auto first = std::ranges::find_if(frames, has_none) - frames.begin();
  return {{"frames without a pose of their own beside ones that have it",
           fmt::format("frames[{}].camera_from_world", first),
           fmt::format(
               "{} of {} frames are taken to be at the camera's own pose", without, frames.size()),
           "state the pose of each frame, or leave out frames whose pose is not known"}};
}

SiteWarnings CheckOpenings(const Sequence& sequence, const Mesh& mesh, const RayCaster& caster) {
  SiteWarnings warnings;
  const std::string remedy = "open it in the mesh; glass counts as opaque, so leave panes out";
  for (std::size_t i = 0; i < sequence.windows.size(); ++i) {
    const WindowCover cover = CoverOf(sequence.windows[i].polygon_world_m, mesh, caster);
    constexpr double kMostCovered = 0.5;  // By frames and bars.
    if (!(cover.share > kMostCovered)) continue;
    warnings.push_back({fmt::format("the window \"{}\" is closed", sequence.windows[i].name),
                        fmt::format("windows[{}]", i),
                        fmt::format("the mesh's \"{}\" stops light in {:.0f} % of its area",
                                    cover.group,
                                    100.0 * cover.share),
                        remedy});
  }
  if (!warnings.empty() || !sequence.fisheye || sequence.frames.empty()) return warnings;
  if (!GetsSky(glm::vec3(sequence.CameraOfFrame(0).CentreWorldM()), caster)) {
    warnings.push_back(
        {"no light of the sky gets in",
         sequence.scene_mesh.string(),
         "no way from the first camera, by reflections, ends in the sky",
         "open doors and windows in the mesh; glass counts as opaque, so leave panes out"});
  }
  return warnings;
}

}  // namespace pleinair
