#include "apps/calibrate_pose_command.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "apps/number_table.h"
#include "apps/picture_files.h"
#include "calib/camera_pose.h"
#include "calib/edge_pose.h"
#include "calib/json_cursor.h"
#include "calib/marker_board.h"
#include "calib/pose_correction.h"
#include "calib/shown_picture.h"
#include "datasets/marker_frame_source.h"
#include "datasets/new_site.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

std::string Metres(const glm::dvec3& point) {
  return fmt::format("{:.3f}, {:.3f}, {:.3f}", point.x, point.y, point.z);
}

// The entries of `frames` as they are written, in the sequence's file or beside it.
Json WrittenFrames(const Sequence& sequence) {
  std::ifstream stream(sequence.file, std::ios::binary);
  Json frames = Json::parse(stream).at("frames");
  if (!frames.is_string()) return frames;
  std::ifstream lines(sequence.folder / frames.get<std::string>(), std::ios::binary);
  frames = Json::array();
  for (std::string line; frames.size() < sequence.frames.size() && std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) frames.push_back(Json::parse(line));
  }
  return frames;
}

// sequence.json with the poses put in, its other text as it was.
void WriteWithPoses(const Sequence& sequence,
                    const std::map<int, glm::dmat4>& camera_from_world,
                    const std::filesystem::path& out) {
  const Json written = WrittenFrames(sequence);
  Json frames = Json::array();
  for (const auto& [index, pose] : camera_from_world) {
    Json frame = written.at(static_cast<std::size_t>(index));
    frame["camera_from_world"] = JsonOf(pose);
    frames.push_back(std::move(frame));
  }
  EditSiteFile(
      sequence.file,
      [&](Json& json) {
        json["camera"].erase("camera_from_world");
        json["frames"] = std::move(frames);
      },
      out);
}

void WritePose(const CalibratePoseOptions& options,
               const glm::dmat4& camera_from_world,
               std::optional<double> stddev_rad) {
  if (!options.out.empty()) {
    SetSitePose(options.site, camera_from_world, stddev_rad, options.out);
  }
}

std::string DescribeKnowledge(const glm::dmat4& camera_from_world,
                              double position_sigma_m,
                              double rotation_sigma_rad) {
  return fmt::format("camera at {} m, sigma {:.1f} mm; its direction, sigma {:.3f} deg",
                     Metres(Camera{{}, camera_from_world}.CentreWorldM()),
                     1000.0 * position_sigma_m,
                     DegFromRad(rotation_sigma_rad));
}

std::string PoseFromPoints(const CalibratePoseOptions& options) {
  const StatedCamera camera = ReadStatedCamera(options.site);
  std::vector<PointMatch> picks;
  for (const std::vector<double>& row : ReadNumberTable(options.points, 5)) {
    picks.push_back({{row[2], row[3], row[4]}, {row[0], row[1]}});
  }
  CameraPoseOptions pose_options = PickedPointOptions();
  if (options.inlier_px) pose_options.inlier_px = *options.inlier_px;
  if (options.near_stated && !camera.camera_from_world) {
    throw std::runtime_error(SiteFileIn(options.site).string() +
                             ": camera.camera_from_world: expected for --near-stated");
  }
  const auto pose = FindCameraPose(Lens(camera.intrinsics),
                                   picks,
                                   pose_options,
                                   options.near_stated ? camera.camera_from_world : std::nullopt);
  if (!pose) throw std::runtime_error(options.points.string() + ": " + pose.error().reason);
  WritePose(options, pose->camera_from_world, pose->rotation_sigma_rad);

  std::string table = "pick    x px    y px  off by px  point m\n";
  for (std::size_t i = 0; i < picks.size(); ++i) {
    const std::string off = std::isfinite(pose->residual_px[i])
                                ? fmt::format("{:.2f}", pose->residual_px[i])
                                : "not in view";
    table += fmt::format("{:>4}  {:>6.1f}  {:>6.1f}  {:>9}  {}{}\n",
                         i + 1,
                         picks[i].pixel.x,
                         picks[i].pixel.y,
                         off,
                         Metres(picks[i].point_world_m),
                         pose->counts[i] ? "" : "  left out");
  }
  if (pose->rival) {
    table += fmt::format(
        "the second-best pose, {:.1f} deg from it, misses them by {:.2f} px (rms)\n",
        DegFromRad(RotationBetweenRad(pose->rival->camera_from_world, pose->camera_from_world)),
        pose->rival->rms_px);
  }
  return table + fmt::format("rms {:.2f} px over {} of {} picks\n{}",
                             pose->rms_px,
                             std::count(pose->counts.begin(), pose->counts.end(), true),
                             picks.size(),
                             DescribeKnowledge(pose->camera_from_world,
                                               pose->position_sigma_m,
                                               pose->rotation_sigma_rad));
}

// The mesh that the site names.
std::filesystem::path MeshOf(const CalibratePoseOptions& options) {
  if (!options.mesh.empty()) return options.mesh;
  const std::filesystem::path file = SiteFileIn(options.site);
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  return file.parent_path() / root.Required("scene").Required("mesh").Text();
}

Rgb8Image ReadPictureOf(const CameraIntrinsics& camera, const std::filesystem::path& file) {
  Rgb8Image picture = HoldsRadiance(file) ? Shown(ReadRadianceImage(file)) : ReadDisplayImage(file);
  if (picture.width != camera.width_px || picture.height != camera.height_px) {
    throw std::runtime_error(fmt::format("{}: expected {}x{} pixels, found {}x{}",
                                         file.string(),
                                         camera.width_px,
                                         camera.height_px,
                                         picture.width,
                                         picture.height));
  }
  return picture;
}

std::string DescribeMove(const glm::dmat4& from, const glm::dmat4& to) {
  return fmt::format("moved by {:.3f} m and turned by {:.2f} deg from the stated pose",
                     glm::distance(Camera{{}, from}.CentreWorldM(), Camera{{}, to}.CentreWorldM()),
                     DegFromRad(RotationBetweenRad(from, to)));
}

std::string PoseFromEdges(const CalibratePoseOptions& options) {
  const StatedCamera camera = ReadStatedCamera(options.site);
  if (!camera.camera_from_world) {
    throw std::runtime_error(SiteFileIn(options.site).string() +
                             ": camera.camera_from_world: expected a rough pose to begin from "
                             "(`calibrate pose --points` finds one from four picks)");
  }
  std::vector<std::filesystem::path> files = options.edges;
  files.insert(files.end(), options.more_edges.begin(), options.more_edges.end());
  if (files.size() > 1 && !options.near_stated) {
    throw std::invalid_argument("--edges: expected one picture, or --near-stated with several");
  }
  const Mesh mesh = LoadMesh(MeshOf(options)).mesh;
  const RayCaster rays(mesh);
  const Lens lens(camera.intrinsics);
  std::vector<Rgb8Image> pictures;
  pictures.reserve(files.size());
  for (const std::filesystem::path& file : files) {
    pictures.push_back(ReadPictureOf(camera.intrinsics, file));
  }
  if (options.near_stated) {
    PoseCorrectionOptions correction;
    correction.reach_px = options.search_px;
    const PoseCorrection found = CorrectPoseByEdges(
        lens, pictures, {EdgesOf(mesh, rays), rays}, *camera.camera_from_world, correction);
    WritePose(options, found.camera_from_world, camera.pose_stddev_rad);
    if (!found.corrected) return "the stated pose stays: " + found.reason;
    constexpr double kEnoughOdds = 1000.0;
    const double odds = std::exp(std::min(found.log_odds, std::log(kEnoughOdds)));
    return fmt::format(
        "{:.0f} % of the mesh's visible edges are found in the pictures, where chance finds "
        "{:.0f} %; they are off by some {:.0f} cm\nthe mesh's edges move by {:.1f} px in the "
        "picture, sigma {:.1f} px; odds for it {}{:.0f} to 1\n{}",
        100.0 * found.found_share,
        100.0 * found.chance_share,
        100.0 * found.mesh_sigma_m,
        found.shift_px,
        found.shift_sigma_px,
        odds < kEnoughOdds ? "" : "above ",
        odds,
        DescribeMove(*camera.camera_from_world, found.camera_from_world));
  }
  EdgePoseOptions edge_options;
  if (options.search_px) edge_options.reach_px = *options.search_px;
  const auto pose = RefinePoseByEdges(
      lens, pictures[0], {EdgesOf(mesh, rays), rays}, *camera.camera_from_world, edge_options);
  if (!pose) throw std::runtime_error(options.edges[0].string() + ": " + pose.error().reason);
  WritePose(options, pose->camera_from_world, pose->rotation_sigma_rad);
  return fmt::format(
      "{:.0f} % of the mesh's visible edges are found in the picture, where chance finds {:.0f} %; "
      "rms {:.2f} px\n{}\n{}",
      100.0 * pose->found_share,
      100.0 * pose->chance_share,
      pose->rms_px,
      DescribeMove(*camera.camera_from_world, pose->camera_from_world),
      DescribeKnowledge(pose->camera_from_world, pose->position_sigma_m, pose->rotation_sigma_rad));
}

std::string DescribeFrame(const MarkerFrameReport& report) {
  if (!report.found) return fmt::format("{:>5}  left out: {}\n", report.index, report.reason);
  const CameraPose& pose = *report.found;
  std::string line = fmt::format("{:>5}  {:>6.2f}  {:>9.2f}  {:>9.3f}  {}",
                                 report.index,
                                 pose.rms_px,
                                 1000.0 * pose.position_sigma_m,
                                 DegFromRad(pose.rotation_sigma_rad),
                                 fmt::join(report.markers, ","));
  if (!report.left_out.empty()) {
    line += fmt::format("; not where the board says: {}", fmt::join(report.left_out, ","));
  }
  if (!report.reason.empty()) line += "; left out: " + report.reason;
  return line + "\n";
}

std::string PosesFromMarkers(const CalibratePoseOptions& options) {
  const Sequence sequence = ReadSequence(options.site, SequencePoses::kMayBeAbsent);
  const MarkerBoard board = ReadMarkerBoard(options.markers);
  std::string table = "frame  rms px  sigma mm   sigma deg  markers\n";
  std::map<int, glm::dmat4> camera_from_world;
  std::string first_reason;
  double squares_px = 0.0;
  MarkerFrameOptions marker_options;
  marker_options.on_frame = [&](const MarkerFrameReport& report) {
    table += DescribeFrame(report);
    if (report.found && report.used && report.used->origin == PoseOrigin::kFound) {
      camera_from_world[report.index] = report.used->camera_from_world;
      squares_px += report.found->rms_px * report.found->rms_px;
    } else if (first_reason.empty()) {
      first_reason = fmt::format("; frame {}: {}", report.index, report.reason);
    }
  };
  const auto frames =
      MakeRecordedMarkerFrameSource(sequence, options.frames, board, std::move(marker_options));
  while (frames->Next()) {
  }
  if (camera_from_world.empty()) {
    throw std::runtime_error(fmt::format("{}: expected frames that show markers of {}{}",
                                         sequence.file.string(),
                                         options.markers.string(),
                                         first_reason));
  }
  const std::size_t count = camera_from_world.size();
  if (!options.out.empty()) WriteWithPoses(sequence, camera_from_world, options.out);
  return table + fmt::format("{} of {} frames have a pose, rms {:.2f} px",
                             count,
                             sequence.frames.size(),
                             std::sqrt(squares_px / static_cast<double>(count)));
}

}  // namespace

std::string RunCalibratePose(const CalibratePoseOptions& options) {
  const int ways = static_cast<int>(!options.markers.empty()) +
                   static_cast<int>(!options.points.empty()) +
                   static_cast<int>(!options.edges.empty());
  if (ways != 1) throw std::invalid_argument("expected one of --points, --edges and --markers");
  if (!options.points.empty()) return PoseFromPoints(options);
  return options.edges.empty() ? PosesFromMarkers(options) : PoseFromEdges(options);
}

}  // namespace pleinair
