#include "session/sequence_site.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "datasets/diffuse_mask.h"
#include "relight/transport/shading_mesh.h"
#include "scene/image_io.h"
#include "scene/lat_long.h"
#include "scene/mesh_io.h"
#include "scene/mesh_orientation.h"
#include "scene/ray_caster.h"
#include "scene/sky_shape.h"
#include "session/available_memory.h"
#include "session/check/clock_check.h"
#include "session/check/geometry_check.h"
#include "session/survey_map_file.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// Probes on the ground itself would see it from within; they start this share of the height above.
constexpr float kProbeFootShare = 0.03f;
// Without virtual objects the light is still computed around the camera's view.
constexpr float kDefaultViewDistanceM = 10.0f;
constexpr float kDefaultProbeBoxM = 2.0f;

// Deviation of guessed albedos of materials, and of defaults: albedos of surfaces outdoors are 0.1
// to 0.6.
constexpr double kAssumedAlbedoStddev = 0.25;
constexpr double kUnknownAlbedoStddev = 0.4;

// Windows throw patches of light some decimetres wide.
constexpr double kIndoorPatchSizeM = 0.25;

void NoteLoading(const std::filesystem::path& file,
                 const MeshReport& report,
                 std::vector<std::string>& notes) {
  const std::int64_t repaired = report.degenerate_triangles_removed +
                                report.duplicate_triangles_removed +
                                report.non_finite_triangles_removed;
  if (repaired > 0) notes.push_back(file.filename().string() + ": " + report.Summary());
  for (const std::string& note : report.notes) {
    notes.push_back(file.filename().string() + ": " + note);
  }
}

// A place between two pixels may be sampled only where one of them may.
Gray8Image TurnedMask(const Gray8Image& mask, double clockwise_rad) {
  Gray8Image turned(mask.width, mask.height);
  const double shift_px = clockwise_rad / (2.0 * std::numbers::pi) * mask.width;
  for (int x = 0; x < mask.width; ++x) {
    const auto column = [&](double at) {
      return static_cast<int>(at - mask.width * std::floor(at / mask.width)) % mask.width;
    };
    const int left = column(std::floor(x - shift_px));
    const int right = column(std::ceil(x - shift_px));
    for (int y = 0; y < mask.height; ++y) {
      turned.At(x, y) = std::min(mask.At(left, y), mask.At(right, y));
    }
  }
  return turned;
}

void Include(const BoundingBox& other, BoundingBox& box) {
  box.lower_m = glm::min(box.lower_m, other.lower_m);
  box.upper_m = glm::max(box.upper_m, other.upper_m);
}

// Around the corners of `box`, moved.
BoundingBox MovedBox(const glm::dmat4& target_from_box, const BoundingBox& box) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  BoundingBox moved{glm::vec3(kInfinity), glm::vec3(-kInfinity)};
  for (const glm::vec3& corner : CornersOf(box)) {
    const glm::vec3 point_m(glm::dvec3(target_from_box * glm::dvec4(glm::dvec3(corner), 1.0)));
    Include({point_m, point_m}, moved);
  }
  return moved;
}

BoundingBox BoxOfObjects(const SequenceSite& site, const Sequence& sequence) {
  BoundingBox box = BoundingBoxOf(site.objects.front().mesh);
  for (std::size_t i = 0; i < site.objects.size(); ++i) {
    const BoundingBox at_start = BoundingBoxOf(site.objects[i].mesh);
    Include(at_start, box);
    if (!site.motions[i].of_part.Moves()) continue;
    for (const FrameEntry& frame : sequence.frames) {
      const double time_s = SecondsSinceFirstFrame(sequence, frame.time);
      Include(MovedBox(site.motions[i].WorldFromStart(time_s), at_start), box);
    }
  }
  box.lower_m.z += kProbeFootShare * (box.upper_m.z - box.lower_m.z);
  return box;
}

// The middle of what a camera looks at: half the way to the surface there, where objects stand.
glm::vec3 MiddleOfView(const Camera& camera, const RayCaster& caster) {
  const glm::vec3 centre_m(camera.CentreWorldM());
  const glm::vec3 forward(glm::transpose(glm::dmat3(camera.camera_from_world))[2]);
  const auto hit = caster.Intersect(centre_m, glm::normalize(forward));
  const float distance_m =
      hit ? std::min(0.5f * hit->distance_m, kDefaultViewDistanceM) : kDefaultViewDistanceM;
  return centre_m + distance_m * glm::normalize(forward);
}

// The middles of all frames' views, without frames near an earlier one. Where the site's own camera
// is stated it comes first: a recording of a camera that moved near there is prepared as its site.
std::vector<glm::dvec3> MiddlesOfViews(const Sequence& sequence, const RayCaster& caster) {
  constexpr double kNearM = 2.0;
  std::vector<glm::dvec3> middles_m;
  const auto add = [&](const Camera& camera) {
    const glm::dvec3 middle_m(MiddleOfView(camera, caster));
    const bool is_new = std::none_of(middles_m.begin(), middles_m.end(), [&](const auto& known_m) {
      return glm::distance(known_m, middle_m) < kNearM;
    });
    if (is_new) middles_m.push_back(middle_m);
  };
  if (sequence.camera_from_world) add({sequence.intrinsics, *sequence.camera_from_world});
  for (std::size_t frame = 0; frame < sequence.frames.size(); ++frame) {
    add(sequence.CameraOfFrame(frame));
  }
  return middles_m;
}

glm::ivec3 ProbeCountsFor(const BoundingBox& box, double spacing_m) {
  constexpr double kMostProbes = 64.0;
  const glm::dvec3 gaps = glm::ceil(glm::dvec3(box.upper_m - box.lower_m) / spacing_m);
  if (!(spacing_m > 0.0) || !(std::max({gaps.x, gaps.y, gaps.z}) < kMostProbes)) {
    throw std::invalid_argument(fmt::format(
        "probe spacing {} m: expected a positive one, with at most 64 probes along each side of "
        "the objects' box",
        spacing_m));
  }
  return glm::ivec3(gaps) + 1;
}

// A room's windows show a camera a few per cent of the sky, a porch half of it. Beside a window
// that may be a third: under a camera that sees the sky for a room, and under a roof, that is
// indoors.
bool IsIndoors(const Sequence& sequence, const RayCaster& caster) {
  constexpr double kLeastSkyOutdoors = 0.15;
  constexpr double kLeastSkyUnderARoof = 0.35;
  constexpr double kOverhead = 0.94;  // Cosine of the angle to the zenith.
  const glm::vec3 centre_m(sequence.CameraOfFrame(0).CentreWorldM());
  int seen = 0;
  int cells = 0;
  bool has_roof = true;
  for (std::size_t cell = 0; cell < SkyTable::kCells; cell += 61) {
    if (!(SkyTable::SolidAngleSr(cell) > 0.0)) continue;
    const glm::vec3 direction(SkyTable::DirectionOfCell(cell));
    ++cells;
    if (caster.Occluded(centre_m, direction)) continue;
    ++seen;
    has_roof = has_roof && direction.z < kOverhead;
  }
  const double least = sequence.fisheye && has_roof ? kLeastSkyUnderARoof : kLeastSkyOutdoors;
  return seen < least * cells;
}

}  // namespace

void SiteObjects::Append(SiteObjects more) {
  const auto append = [](auto& values, auto& added) {
    std::move(added.begin(), added.end(), std::back_inserter(values));
  };
  append(parts, more.parts);
  append(motions, more.motions);
  append(notes, more.notes);
}

SiteObjects LoadObject(const std::filesystem::path& folder,
                       const VirtualObjectEntry& entry,
                       std::size_t index) {
  SiteObjects object;
  LoadedParts loaded = LoadMeshParts(folder / entry.mesh, MeshColours::kByPlace);
  NoteLoading(entry.mesh, loaded.report, object.notes);
  std::int64_t turned = 0;
  for (MeshPart& part : loaded.parts) {
    turned += TurnClosedPartsOutward(part.mesh);
    object.parts.push_back({MakeShadingMesh(TransformMesh(entry.world_from_object, part.mesh))});
    object.motions.push_back({index, entry.world_from_object, std::move(part.motion)});
  }
  if (turned > 0) {
    object.notes.push_back(entry.mesh.filename().string() + ": " + std::to_string(turned) +
                           " triangles of closed parts were inside out and have been turned");
  }
  return object;
}

glm::dmat4 ObjectMotion::WorldFromStart(double time_s) const {
  const glm::dmat4 file_from_start = of_part.FileFromStart(time_s);
  if (file_from_start == glm::dmat4(1.0)) return file_from_start;
  glm::dmat4 world_from_start = world_from_file * file_from_start * glm::inverse(world_from_file);
  // Exactly affine: the product's last row has rounding errors.
  for (int column = 0; column < 4; ++column) world_from_start[column].w = column == 3 ? 1.0 : 0.0;
  return world_from_start;
}

std::vector<glm::dmat4> ObjectPosesAt(std::span<const ObjectMotion> motions, double time_s) {
  const bool moves = std::any_of(
      motions.begin(), motions.end(), [](const auto& motion) { return motion.of_part.Moves(); });
  std::vector<glm::dmat4> poses;
  if (!moves) return poses;
  for (const ObjectMotion& motion : motions) poses.push_back(motion.WorldFromStart(time_s));
  return poses;
}

double SecondsSinceFirstFrame(const Sequence& sequence, UtcTime time) {
  return std::chrono::duration<double>(time - sequence.frames.front().time).count();
}

SequenceSite LoadSequenceSite(const Sequence& sequence) {
  SequenceSite site;
  LoadedMesh scene = LoadMesh(sequence.folder / sequence.scene_mesh);
  NoteLoading(sequence.scene_mesh, scene.report, site.notes);
  site.model.mesh = std::move(scene.mesh);
  const RayCaster caster(site.model.mesh);
  site.is_indoors = IsIndoors(sequence, caster);
  double map_turned_rad = 0.0;
  if (sequence.environment) {
    LoadedSurveyMap loaded = LoadSurveyMap(sequence, site.is_indoors, site.notes);
    map_turned_rad = loaded.turned_rad;
    site.model.environment = std::move(loaded.map);
  } else if (!sequence.albedos_known) {
    site.albedo_is_a_guess = sequence.albedos_assumed;
    site.model.material_albedo_stddev =
        sequence.albedos_assumed ? kAssumedAlbedoStddev : kUnknownAlbedoStddev;
    site.materials_note = fmt::format(
        "no environment map: the materials' {} is used, +/- {:.0f} %, and the light's colour is "
        "known only as well",
        sequence.albedos_assumed ? "assumed albedo" : "Kd, which is neither known nor assumed,",
        100.0 * site.model.material_albedo_stddev);
  }
  site.model.diffuse_regions = sequence.diffuse_regions;
  if (auto mask = ReadDiffuseMask(sequence); mask && mask->is_over_map) {
    site.model.diffuse_mask = std::move(mask->image);
    if (map_turned_rad != 0.0) {
      site.model.diffuse_mask = TurnedMask(*site.model.diffuse_mask, map_turned_rad);
    }
  }
  SiteObjects objects;
  for (std::size_t i = 0; i < sequence.virtual_objects.size(); ++i) {
    objects.Append(LoadObject(sequence.folder, sequence.virtual_objects[i], i));
  }
  site.objects = std::move(objects.parts);
  site.motions = std::move(objects.motions);
  site.notes.insert(site.notes.end(), objects.notes.begin(), objects.notes.end());
  const Mesh& mesh = site.model.mesh;
  const auto add = [&](SiteWarnings some) {
    std::ranges::move(some, std::back_inserter(site.warnings));
  };
  add(CheckUnits(sequence, mesh, caster, site.objects, site.motions));
  if (!site.IsMisread() && CheckAxes(sequence, mesh, caster).empty()) {
    SiteWarnings of_pose = CheckPose(sequence, caster);
    std::erase_if(of_pose, [](const SiteWarning& warning) { return !warning.spoils_forecast; });
    add(std::move(of_pose));
  }
  if (!site.IsMisread()) add(CheckOpenings(sequence, mesh, caster));
  add(CheckFrameOrder(sequence));
  add(CheckFramePoses(sequence));
  if (site.is_indoors) {
    site.notes.emplace_back(
        "the camera stands indoors: the mesh's ground is not carried on outside; without "
        "the setting prepare.ground_albedo nothing shines from below the horizon");
  }
  site.viewed_m = MiddlesOfViews(sequence, caster);
  const glm::vec3 middle_m(site.viewed_m.front());
  site.probe_box = site.objects.empty() ? BoundingBox{middle_m - 0.5f * kDefaultProbeBoxM,
                                                      middle_m + 0.5f * kDefaultProbeBoxM}
                                        : BoxOfObjects(site, sequence);
  return site;
}

PrepareOptions PrepareOptionsFor(const SequenceSite& site, const PrepareSettings& settings) {
  PrepareOptions options;
  options.bounces = settings.bounces;
  options.memory_limit_bytes = AvailableMemoryBytes();
  options.probe_box = site.probe_box;
  options.patches.focus_points_m = site.viewed_m;
  options.patches.extend_ground = !site.is_indoors;
  options.patches.ground_albedo = settings.ground_albedo;
  if (site.is_indoors) options.patches.patch_size_m = kIndoorPatchSizeM;
  if (settings.patch_size_m) options.patches.patch_size_m = *settings.patch_size_m;
  options.gather.seed = settings.seed;
  options.probes.seed = settings.seed;
  if (settings.probe_rays) options.probes.rays_per_probe = *settings.probe_rays;
  if (settings.rays) options.gather.rays_per_receiver = *settings.rays;
  if (settings.map_width) options.survey_map_width = *settings.map_width;
  if (settings.probe_counts) options.probe_counts = *settings.probe_counts;
  if (settings.probe_spacing_m) {
    options.probe_counts = ProbeCountsFor(site.probe_box, *settings.probe_spacing_m);
  }
  return options;
}

}  // namespace pleinair
