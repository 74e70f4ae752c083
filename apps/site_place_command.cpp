#include "apps/site_place_command.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "datasets/site_objects.h"
#include "objects/object_placement.h"
#include "objects/surface_point.h"
#include "scene/mesh_io.h"
#include "session/corrected_pose.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

Sequence ReadSiteOrSequence(const fs::path& folder) {
  return SiteFileIn(folder).filename() == "site.json"
             ? ReadSite(folder, UtcTime{}, SequencePoses::kMayBeAbsent)
             : ReadSequence(folder, SequencePoses::kMayBeAbsent);
}

// Which of the site's objects is meant; none: a mesh file.
std::optional<std::size_t> IndexOf(const std::string& object, const Sequence& site) {
  if (!std::all_of(object.begin(), object.end(), [](unsigned char c) { return std::isdigit(c); })) {
    return std::nullopt;
  }
  const std::size_t count = site.virtual_objects.size();
  std::size_t index = count;
  std::from_chars(object.data(), object.data() + object.size(), index);
  if (index < count) return index;
  throw std::invalid_argument(
      count == 0 ? fmt::format("--object {}: the site has no objects", object)
                 : fmt::format("--object {}: expected an index from 0 to {}", object, count - 1));
}

SurfacePoint PickedPoint(const SitePlaceOptions& options,
                         const Sequence& site,
                         const Mesh& mesh,
                         const RayCaster& caster) {
  if (!options.pixel.empty()) {
    if (static_cast<std::size_t>(options.frame) >= site.frames.size()) {
      throw std::invalid_argument(
          fmt::format("--frame {}: expected one of {}", options.frame, site.frames.size()));
    }
    const Camera camera = site.CameraOfFrame(static_cast<std::size_t>(options.frame));
    const glm::dvec2 pixel(options.pixel[0], options.pixel[1]);
    const std::string where = fmt::format("--pixel {},{}: ", pixel.x, pixel.y);
    const CameraIntrinsics& lens = camera.intrinsics;
    if (!(pixel.x >= -0.5 && pixel.y >= -0.5 && pixel.x <= lens.width_px - 0.5 &&
          pixel.y <= lens.height_px - 0.5)) {
      throw std::invalid_argument(fmt::format(
          "{}expected a place in a picture of {}x{}", where, lens.width_px, lens.height_px));
    }
    if (auto point = SurfaceAt(caster, mesh, camera, pixel)) return *std::move(point);
    throw std::runtime_error(where + "the mesh has no surface there");
  }
  const glm::dvec3 at_m(options.at_m[0], options.at_m[1], options.at_m[2]);
  if (!std::isfinite(glm::dot(at_m, at_m))) {
    throw std::invalid_argument("--at: expected three finite numbers");
  }
  // Without a camera, sheets are looked at from above.
  const bool has_pose = site.camera_from_world || site.frames.front().camera_from_world;
  const glm::dvec3 eye_m =
      has_pose ? site.CameraOfFrame(0).CentreWorldM() : at_m + glm::dvec3(0.0, 0.0, 1000.0);
  if (auto point = NearestSurface(mesh, at_m, eye_m)) return *std::move(point);
  throw std::runtime_error((site.folder / site.scene_mesh).string() + ": has no surface");
}

std::string TextOf(const glm::dvec3& v) {
  return fmt::format("{:.3f},{:.3f},{:.3f}", v.x, v.y, v.z);
}

// The pose, and what was done to get there. A pixel's place is where runs have it: they correct a
// camera's pose that is nearly right.
std::pair<glm::dmat4, std::string> Placed(const SitePlaceOptions& options,
                                          Sequence site,
                                          const fs::path& object_file,
                                          glm::dmat4 pose) {
  const PlaceableObject object(LoadMesh(object_file, MeshColours::kByPlace).mesh);
  if (options.scale != 1.0) pose = Scaled(object, pose, options.scale);
  if (options.turn_deg != 0.0) pose = Turned(object, pose, RadFromDeg(options.turn_deg));
  std::string report;
  if (!options.pixel.empty() || !options.at_m.empty()) {
    const Mesh mesh = LoadMesh(site.folder / site.scene_mesh).mesh;
    const std::string correction =
        options.pixel.empty() ? std::string() : CorrectPose(SessionOptions(), mesh, site);
    const RayCaster caster(mesh);
    const SurfacePoint point = PickedPoint(options, site, mesh, caster);
    const auto resting = RestOn(object, pose, point, caster, mesh);
    if (!resting) {
      throw std::runtime_error(
          fmt::format("no room for {} at {} on `{}`: expected a place where it "
                      "does not stand in other surfaces (or a smaller --scale)",
                      object_file.string(),
                      TextOf(point.position_m),
                      point.group));
    }
    pose = resting->world_from_object;
    report = fmt::format(" on `{}`, normal {}", point.group, TextOf(point.normal));
    const double slid_m = glm::length(resting->slid_m);
    if (slid_m > 1e-3) report += fmt::format(", slid {:.3f} m out of what stands there", slid_m);
    if (std::abs(resting->raised_m) > 1e-3) {
      report += fmt::format(", {} {:.3f} m to its first contact",
                            resting->raised_m > 0.0 ? "raised" : "lowered",
                            std::abs(resting->raised_m));
    }
    if (!correction.empty()) report += "; " + correction;
  }
  if (options.lift_m != 0.0) pose = Lifted(pose, options.lift_m);
  return {pose, "foot at " + TextOf(FootOf(object, pose)) + report};
}

}  // namespace

std::string RunSitePlace(const SitePlaceOptions& options) {
  const Sequence site = ReadSiteOrSequence(options.folder);
  std::vector<VirtualObjectEntry> objects = site.virtual_objects;
  const auto index = IndexOf(options.object, site);
  if (options.remove) {
    if (!index) throw std::invalid_argument("--remove: expected --object with an index");
    const fs::path mesh = objects[*index].mesh;
    objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(*index));
    SaveObjects(options.folder, objects);
    return fmt::format(
        "{}: without {}, {} objects", site.file.string(), mesh.string(), objects.size());
  }
  if (!std::isfinite(options.turn_deg) || !std::isfinite(options.lift_m)) {
    throw std::invalid_argument("--turn-deg, --lift: expected finite numbers");
  }
  if (index) {
    VirtualObjectEntry& object = objects[*index];
    std::string report;
    std::tie(object.world_from_object, report) =
        Placed(options, site, site.folder / object.mesh, object.world_from_object);
    SaveObjects(options.folder, objects);
    return fmt::format(
        "{}: object {} ({}), {}", site.file.string(), *index, object.mesh.string(), report);
  }
  if (options.pixel.empty() && options.at_m.empty()) {
    throw std::invalid_argument("--object " + options.object +
                                ": expected --pixel or --at, where to put it");
  }
  const auto [pose, report] = Placed(options, site, options.object, glm::dmat4(1.0));
  objects.push_back({BringObjectFile(options.folder, options.object), pose});
  SaveObjects(options.folder, objects);
  return fmt::format("{}: object {} ({}), {}",
                     site.file.string(),
                     objects.size() - 1,
                     objects.back().mesh.string(),
                     report);
}

}  // namespace pleinair
