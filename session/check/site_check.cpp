#include "session/check/site_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "datasets/fisheye_setup.h"
#include "estimation/fisheye_sky.h"
#include "pipeline/shadow_direction.h"
#include "pipeline/sun_state.h"
#include "scene/angle_between.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "session/check/clock_check.h"
#include "session/check/edge_check.h"
#include "session/check/geometry_check.h"
#include "session/check/map_check.h"
#include "session/corrected_pose.h"
#include "session/direction_text.h"
#include "session/map_sun_check.h"
#include "session/sequence_site.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

void Append(SiteWarnings more, SiteWarnings& warnings) {
  warnings.insert(
      warnings.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

// "expected is ..." with what would explain the suns.
std::string RemedyFor(std::span<const SeenSun> suns, const std::optional<Site>& site) {
  const std::vector<std::string> explanations =
      site ? ExplanationsOf(suns, *site) : std::vector<std::string>();
  if (explanations.empty()) {
    return "no time, longitude or north explains it: check the mesh, the pose and the place";
  }
  std::string text = "explained by ";
  for (std::size_t i = 0; i < explanations.size(); ++i) {
    text += (i == 0 ? "" : ", or by ") + explanations[i];
  }
  return text;
}

std::string Words(const MapLayoutFit& fit) {
  switch (fit.best) {
    case MapLayout::kUpsideDown:
      return "upside down (its rows in reverse order)";
    case MapLayout::kHalfTurned:
      return "turned upside down (by half a turn)";
    case MapLayout::kMirrored:
      return "mirrored left to right";
    case MapLayout::kAsStated:
      break;
  }
  return "turned about the vertical";
}

std::string Describe(const MapSunDisagreement& found,
                     const char* how,
                     const glm::dvec3& expected_enu) {
  return fmt::format("the map shows it at {}, {} is {}: {:.1f} deg apart, {:.1f} of azimuth",
                     AzimuthAndElevation(found.shown.direction_enu),
                     how,
                     AzimuthAndElevation(expected_enu),
                     DegFromRad(found.angle_rad),
                     DegFromRad(found.turn_rad));
}

SiteWarnings CheckMap(const Sequence& sequence, const Mesh& mesh, const RayCaster& caster) {
  SiteWarnings warnings;
  const EnvironmentEntry& entry = *sequence.environment;
  RgbImage map = ReadRadianceImage(sequence.folder / entry.image);
  RepairRadiance(map);
  const MapLayoutFit fit = FitMapLayout(map, entry.position_m, mesh, caster);
  if (fit.ContradictsTheMap()) {
    const bool is_turned = fit.turn_rad != 0.0;
    warnings.push_back(
        {"the environment map is " + Words(fit),
         entry.image.string(),
         fmt::format("the mesh's surfaces, seen from environment.position_m, explain {:.0f} % of "
                     "its variance, and {:.0f} % when it is put right{}",
                     100.0 * fit.explained_as_stated,
                     100.0 * fit.explained,
                     is_turned ? fmt::format(" and turned by {:+.0f} deg, clockwise from above",
                                             DegFromRad(fit.turn_rad))
                               : std::string()),
         "expected is row 0 at the zenith, +Y (north) in the middle column, +X (east) to the right "
         "of it: convert the picture"});
  }
  if (const std::optional<glm::dvec3>& stated = entry.sun_direction_enu) {
    if (const auto found = CompareWithMapSun(map, glm::normalize(*stated))) {
      warnings.push_back({"the environment map's sun is not where it is stated",
                          "environment.sun_direction_enu",
                          Describe(*found, "stated", *stated),
                          "correct it, or the map's orientation"});
    }
    return warnings;
  }
  if (!sequence.site) return warnings;
  const glm::dvec3 computed = SunOverSite(*sequence.site, entry.time).direction_enu;
  const double in_north = std::max({kWorthAWarningRad, 2.0 * sequence.north_stddev_rad});
  const auto found = CompareWithMapSun(map, computed, in_north);
  if (!found) return warnings;
  const MapSun& shown = found->shown;
  const glm::dvec3 mirrored(-shown.direction_enu.x, shown.direction_enu.y, shown.direction_enu.z);
  const SeenSun seen{entry.time, shown.direction_enu, shown.uncertain_rad};
  std::string remedy = RemedyFor(std::span(&seen, 1), sequence.site);
  if (AngleBetweenRad(mirrored, computed) <= in_north + shown.uncertain_rad) {
    remedy += "; a map that is mirrored left to right would explain it, too";
  }
  warnings.push_back({"the environment map's sun is not where place and time have it",
                      "environment.time_utc",
                      Describe(*found, "computed", computed),
                      remedy});
  return warnings;
}

// The only edge of a mesh in one plane is where it was cut off.
bool IsOnePlane(const Mesh& mesh) {
  const BoundingBox box = BoundingBoxOf(mesh);
  constexpr float kMostM = 0.02f;  // Kerbs and steps are edges.
  const float tolerance_m = std::min(1e-3f * glm::distance(box.lower_m, box.upper_m), kMostM);
  std::optional<glm::vec3> normal;
  for (std::uint32_t t = 0; t < mesh.triangles.size() && !normal; ++t) {
    const glm::vec3 of_triangle = TriangleNormal(mesh, t);
    if (glm::length(of_triangle) > 0.5f) normal = of_triangle;
  }
  if (!normal) return true;
  const glm::vec3& origin_m = mesh.positions_m[mesh.triangles.front().x];
  return std::ranges::all_of(mesh.triangles, [&](const glm::uvec3& triangle) {
    return std::ranges::all_of(std::array{triangle.x, triangle.y, triangle.z}, [&](auto corner) {
      return std::abs(glm::dot(mesh.positions_m[corner] - origin_m, *normal)) <= tolerance_m;
    });
  });
}

// A run fails on frames whose sun nothing states. A map shows it: see FindSunInMap.
SiteWarnings CheckSunIsStated(const Sequence& sequence) {
  if (sequence.site || sequence.environment) return {};
  std::size_t without = 0;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const bool is_stated = sequence.StatedSunDirectionEnu(i).has_value();
    if (!is_stated && sequence.WeatherOfFrame(i) != Weather::kOvercast) ++without;
  }
  if (without == 0) return {};
  return {{"nothing says where the sun is",
           "site",
           fmt::format("{} of {} frames have no sun_direction_enu and are not \"overcast\": runs "
                       "fail on them",
                       without,
                       sequence.frames.size()),
           "state the key site (latitude_deg, longitude_deg, height_m), or the frames' "
           "sun_direction_enu"}};
}

// The key that states the sun of a frame.
std::string KeyOfStatedSun(const Sequence& sequence, std::size_t frame) {
  if (sequence.frames[frame].sun_direction_enu) {
    return fmt::format("frames[{}].sun_direction_enu", frame);
  }
  return "environment.sun_direction_enu";
}

// Checks where the shadows of some frames have the sun, against what states it or place and time.
class ShownSuns {
 public:
  ShownSuns(const Sequence& sequence, const Mesh& mesh)
      : sequence_(sequence), finder_(mesh, sequence.diffuse_regions) {}

  // `index` is the frame's in the sequence.
  void Add(const Frame& frame, std::size_t index) {
    const bool is_stated = frame.sun_direction_enu.has_value();
    if (!is_stated && !sequence_.site) return;
    const glm::dvec3 expected = is_stated ? *frame.sun_direction_enu
                                          : SunOverSite(*sequence_.site, frame.time).direction_enu;
    if (expected == kNoSunDirectionEnu) return;
    const ShownSun shown = finder_.ShownBy(frame, expected);
    if (!(shown.stddev_rad > 0.0)) return;
    if (!is_stated) suns_.push_back({frame.time, shown.direction_enu, shown.stddev_rad});
    std::optional<SiteWarning>& warning = is_stated ? stated_ : computed_;
    const double apart = AngleBetweenRad(shown.direction_enu, expected);
    const double least_rad =
        std::max(kWorthAWarningRad, is_stated ? 0.0 : 2.0 * sequence_.north_stddev_rad);
    if (!shown.contradicts || warning || apart < least_rad) return;
    warning = SiteWarning{
        is_stated ? "the sun in the pictures is not where it is stated, or the map shows it"
                  : "the sun in the pictures is not where place and time have it",
        is_stated ? KeyOfStatedSun(sequence_, index) : "frames[].time_utc, site",
        fmt::format("the shadows in frame {} show it at {} (sigma {:.1f} deg), {} is {}: {:.1f} "
                    "deg apart",
                    index,
                    AzimuthAndElevation(shown.direction_enu),
                    DegFromRad(shown.stddev_rad),
                    is_stated ? "expected" : "computed",
                    AzimuthAndElevation(expected),
                    DegFromRad(apart)),
        is_stated
            ? "correct it, or the camera's pose; over hours the sun moves: state site and times, "
              "or each frame's sun_direction_enu"
            : ""};
  }

  void Report(SiteWarnings& warnings) {
    if (computed_) {
      computed_->remedy = RemedyFor(suns_, sequence_.site);
      warnings.push_back(*std::move(computed_));
    }
    if (stated_) warnings.push_back(*std::move(stated_));
  }

 private:
  const Sequence& sequence_;
  ShadowDirectionFinder finder_;
  std::vector<SeenSun> suns_;  // Of frames whose sun is computed.
  // The first contradictions.
  std::optional<SiteWarning> computed_;
  std::optional<SiteWarning> stated_;
};

// Checks where fish-eye pictures show the sun, as runs do.
class FisheyeSuns {
 public:
  explicit FisheyeSuns(const Sequence& sequence) : site_(sequence.site) {
    if (!HasFisheyePictures(sequence)) return;
    sky_.emplace(MakeFisheyeSetup(*sequence.fisheye, sequence.folder).camera, SkyRegions());
  }

  // `index` is the frame's in the sequence.
  void Add(const Frame& frame, std::size_t index, SiteWarnings& warnings) {
    if (!sky_ || !frame.fisheye_radiance || !(site_ || frame.sun_direction_enu)) return;
    const SunState sun = SunOfFrame(site_, frame);
    sky_->Read(*frame.fisheye_radiance, sun.direction_enu, sun.angular_radius_rad);
    const std::optional<glm::dvec3> shown = sky_->Sun().elsewhere_enu;
    if (!shown) return;
    warnings.push_back(
        {"the fish-eye pictures show the sun elsewhere",
         "fisheye, frames[].time_utc, site",
         fmt::format("frame {} shows it at {}, stated or computed is {}: {:.1f} deg apart",
                     index,
                     AzimuthAndElevation(*shown),
                     AzimuthAndElevation(sun.direction_enu),
                     DegFromRad(AngleBetweenRad(*shown, sun.direction_enu))),
         "correct fisheye.up, image_up, image_right or fov_deg (pleinair calibrate orientation), "
         "or "
         "the sun's direction, the place or the time"});
    sky_.reset();  // One is enough.
  }

 private:
  std::optional<Site> site_;
  std::optional<FisheyeSky> sky_;
};

// Checks edges, shadows and the sun of the sky in pictures.
SiteWarnings CheckPictures(const Sequence& sequence,
                           FrameKind kind,
                           const Mesh& mesh,
                           const RayCaster& caster) {
  SiteWarnings warnings;
  constexpr std::size_t kMostLooks = 6;
  const std::size_t stride = (sequence.frames.size() + kMostLooks - 1) / kMostLooks;
  Sequence looked_at = sequence;
  looked_at.frames.clear();
  for (std::size_t i = 0; i < sequence.frames.size(); i += stride) {
    looked_at.frames.push_back(sequence.frames[i]);
  }
  EdgeChecker edges(mesh, caster);
  const bool has_edges = !IsOnePlane(mesh);
  ShownSuns suns(sequence, mesh);
  FisheyeSuns fisheye_suns(sequence);
  const auto source = MakeRecordedFrameSource(looked_at, kind);
  std::vector<std::string> unreadable;
  while (const auto next = source->Next()) {
    if (!*next) {
      unreadable.push_back(next->error().reason);
      continue;
    }
    const Frame& frame = **next;
    if (has_edges) edges.Add(frame.radiance, frame.camera);
    const std::size_t index = static_cast<std::size_t>(frame.index) * stride;
    suns.Add(frame, index);
    fisheye_suns.Add(frame, index, warnings);
  }
  if (!unreadable.empty()) {
    warnings.push_back({"pictures cannot be used",
                        "frames",
                        fmt::format("{} of the {} that were looked at, the first: {}",
                                    unreadable.size(),
                                    looked_at.frames.size(),
                                    unreadable.front()),
                        "correct the files, or the keys that name them"});
  }
  suns.Report(warnings);
  const EdgeFit fit = edges.Result();
  if (fit.IsShifted()) {
    warnings.push_back(
        {"the mesh's edges are not where the pictures have them",
         "camera_from_world, " + sequence.scene_mesh.string(),
         fmt::format("pictures and mesh fit with the mesh moved by {:+.0f} px to the right and "
                     "{:+.0f} px down, of {} px width",
                     fit.shift.x * sequence.intrinsics.width_px,
                     fit.shift.y * sequence.intrinsics.width_px,
                     sequence.intrinsics.width_px),
         "find the pose again (pleinair calibrate pose), or check the mesh's scale"});
  } else if (fit.IsLost()) {
    warnings.push_back({"the mesh's edges are nowhere near edges of the pictures",
                        "camera_from_world, " + sequence.scene_mesh.string(),
                        fmt::format("no shift of up to 6 % of the width brings them together "
                                    "(contrast over the edges {:.1f} deviations above that of "
                                    "random places; a fit has 2.4 and more)",
                                    fit.sharpness_as_stated),
                        "find the pose again (pleinair calibrate pose), or check mesh and lens"});
  } else {
    // By the frames that runs look at; only all together say whether the camera moves.
    Sequence corrected = sequence;
    SessionOptions options;
    options.frames = kind;
    const std::string correction = CorrectPose(options, mesh, corrected);
    if (!correction.empty()) {
      warnings.push_back({"the camera's pose is nearly right, and runs correct it",
                          "camera_from_world",
                          correction,
                          "keep the better one (pleinair calibrate pose --near-stated --edges)"});
    }
  }
  return warnings;
}

}  // namespace

SiteWarnings CheckSite(const Sequence& sequence, FrameKind frames) {
  const SequenceSite site = LoadSequenceSite(sequence);
  const Mesh& mesh = site.model.mesh;
  const RayCaster caster(mesh);
  SiteWarnings warnings = site.warnings;
  SiteWarnings axes = CheckAxes(sequence, mesh, caster);
  // In a mesh that is turned no pose looks right. What is sure of it is in the site's warnings.
  if (axes.empty() && !site.IsMisread()) axes = CheckPose(sequence, caster);
  Append(std::move(axes), warnings);
  // With another unit or other axes nothing is where it is looked for.
  const bool is_unusable = std::ranges::any_of(warnings, &SiteWarning::spoils_forecast);
  if (!is_unusable) Append(CheckPlaces(sequence, caster), warnings);
  if (sequence.environment) Append(CheckMap(sequence, mesh, caster), warnings);
  if (sequence.HasPictures()) {
    Append(CheckSunIsStated(sequence), warnings);
    Append(CheckFrameTimes(sequence), warnings);
    Append(CheckPictures(sequence, frames, mesh, caster), warnings);
  }
  return warnings;
}

}  // namespace pleinair
