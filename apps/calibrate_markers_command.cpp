#include "apps/calibrate_markers_command.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "calib/marker_bundle.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

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

}  // namespace pleinair
