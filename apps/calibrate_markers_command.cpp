#include "apps/calibrate_markers_command.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "apps/whole_text.h"
#include "calib/marker_bundle.h"
#include "datasets/marker_frame_source.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

template <typename Pixel>
void RequireSize(const Image<Pixel>& picture,
                 const CameraIntrinsics& camera,
                 const std::filesystem::path& file) {
  if (picture.width == camera.width_px && picture.height == camera.height_px) return;
  throw std::runtime_error(
      fmt::format("{}: expected {}x{} pixels (camera.width, camera.height), found {}x{}",
                  file.string(),
                  camera.width_px,
                  camera.height_px,
                  picture.width,
                  picture.height));
}

Gray8Image ReadMarkerPicture(const std::filesystem::path& file, const CameraIntrinsics& camera) {
  if (HoldsRadiance(file)) {
    const RgbImage picture = ReadRadianceImage(file);
    RequireSize(picture, camera, file);
    return MarkerPicture(picture);
  }
  const Rgb8Image picture = ReadDisplayImage(file);
  RequireSize(picture, camera, file);
  return MarkerPicture(picture);
}

std::string DescribeBoard(const MarkerBoardFit& fit) {
  std::string text = "marker  pictures  rms px  centre m (x, y, z)\n";
  for (std::size_t i = 0; i < fit.placed.size(); ++i) {
    glm::dvec3 centre(0.0);
    for (const glm::dvec3& corner : fit.board.markers[i].corners_world_m) centre += 0.25 * corner;
    // A rounded -0 reads like a sign.
    const auto shown = [](double value) { return std::abs(value) < 5e-5 ? 0.0 : value; };
    text += fmt::format("{:>6}  {:>8}  {:>6.2f}  {:.4f}, {:.4f}, {:.4f}{}\n",
                        fit.placed[i].id,
                        fit.placed[i].views,
                        fit.placed[i].rms_px,
                        shown(centre.x),
                        shown(centre.y),
                        shown(centre.z),
                        fit.placed[i].views == 1 ? "  (in one picture only)" : "");
  }
  for (const int id : fit.unplaced) {
    text += fmt::format("{:>6}  left out: in no picture with one that is placed\n", id);
  }
  return text;
}

// sequence.json with the poses put in, its other text as it was.
void WriteWithPoses(const Sequence& sequence,
                    const std::map<int, glm::dmat4>& camera_from_world,
                    const std::filesystem::path& out) {
  std::ifstream stream(sequence.folder / "sequence.json", std::ios::binary);
  Json document = Json::parse(stream);
  document["camera"].erase("camera_from_world");
  Json frames = Json::array();
  for (const auto& [index, pose] : camera_from_world) {
    Json frame = document["frames"][static_cast<std::size_t>(index)];
    Json rows = Json::array();
    for (int row = 0; row < 4; ++row) {
      rows.push_back({pose[0][row], pose[1][row], pose[2][row], pose[3][row]});
    }
    frame["camera_from_world"] = std::move(rows);
    frames.push_back(std::move(frame));
  }
  document["frames"] = std::move(frames);
  WriteWholeText(out, document.dump(1) + "\n");
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

}  // namespace

std::string RunCalibrateMarkers(const CalibrateMarkersOptions& options) {
  const CameraIntrinsics camera = ReadCameraIntrinsics(options.camera);
  std::vector<MarkerView> views;
  std::vector<RejectedMarkerView> unread;
  for (const std::filesystem::path& file : options.pictures) {
    try {
      views.push_back(
          {file.string(), DetectMarkers(ReadMarkerPicture(file, camera), options.dictionary)});
    } catch (const std::runtime_error& error) {
      unread.push_back({file.string(), error.what()});
    }
  }
  if (views.empty() && !unread.empty()) throw std::runtime_error(unread[0].reason);
  MarkerBoardFit fit =
      FitMarkerBoard(Lens(camera), options.dictionary, options.size_m, views, options.reference);
  std::string placed = fmt::format(
      "The origin is the centre of marker {}: x to its right, y to its top, z out of it.\n",
      fit.reference_id);
  if (!options.anchor.empty()) {
    const double off_m = MoveBoardTo(ReadMarkerBoard(options.anchor), fit.board);
    placed = fmt::format("Moved to where {} says; corners miss that by {:.1f} mm (rms).\n",
                         options.anchor.string(),
                         1000.0 * off_m);
  }
  WriteWholeText(options.out, MarkerBoardText(fit.board));

  std::string report;
  for (const FittedMarkerView& view : fit.fitted) {
    report += fmt::format("{}: {} markers, rms {:.2f} px\n", view.name, view.markers, view.rms_px);
  }
  for (const auto& rejected : {unread, fit.rejected}) {
    for (const RejectedMarkerView& view : rejected) {
      report += fmt::format("{}: left out: {}\n", view.name, view.reason);
    }
  }
  return report + DescribeBoard(fit) + placed +
         fmt::format("rms {:.3f} px over {} pictures", fit.rms_px, fit.fitted.size());
}

std::string RunCalibratePose(const CalibratePoseOptions& options) {
  const Sequence sequence = ReadSequence(options.sequence, SequencePoses::kMayBeAbsent);
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

}  // namespace pleinair
