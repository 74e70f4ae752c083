#include "apps/shadow_edges_report.h"

#include <map>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/number_table.h"
#include "pipeline/shadow_edge_marks.h"
#include "pipeline/sun_state.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

struct NumberedMark {
  int frame = 0;
  ShadowEdgeMark mark;
};

std::vector<NumberedMark> ReadMarks(const Sequence& sequence,
                                    FrameKind kind,
                                    const std::filesystem::path& file,
                                    double stated_north_rad) {
  std::vector<NumberedMark> marks;
  std::map<int, std::vector<std::size_t>> marks_of;
  const auto rows = ReadNumberTable(file, 3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double frame = rows[i][0];
    if (!(frame >= 0.0) || frame >= static_cast<double>(sequence.frames.size()) ||
        frame != static_cast<double>(static_cast<int>(frame))) {
      throw std::runtime_error(fmt::format("{}: mark {}: frame is {}: expected 0 to {}",
                                           file.string(),
                                           i,
                                           frame,
                                           sequence.frames.size() - 1));
    }
    marks.push_back({static_cast<int>(frame), {{}, {rows[i][1], rows[i][2]}, {}}});
    marks_of[static_cast<int>(frame)].push_back(i);
  }
  const auto source = MakeRecordedFrameSource(sequence, kind);
  for (int index = 0; const auto frame = source->Next(); ++index) {
    const auto wanted = marks_of.find(index);
    if (wanted == marks_of.end()) continue;
    if (!*frame) {
      throw std::runtime_error(
          fmt::format("frame {} has marks, but: {}", index, frame->error().reason));
    }
    const glm::dvec3 sun =
        TurnedClockwise(SunOfFrame(sequence.site, **frame).direction_enu, -stated_north_rad);
    for (const std::size_t i : wanted->second) {
      ShadowEdgeMark& mark = marks[i].mark;
      mark.camera = (*frame)->camera;
      mark.sun_direction_enu = sun;
      const CameraIntrinsics& picture = mark.camera.intrinsics;
      if (!(mark.pixel.x >= -0.5 && mark.pixel.x <= picture.width_px - 0.5 &&
            mark.pixel.y >= -0.5 && mark.pixel.y <= picture.height_px - 0.5)) {
        throw std::runtime_error(
            fmt::format("{}: mark {}: ({}, {}) is outside the picture of {}x{}",
                        file.string(),
                        i,
                        mark.pixel.x,
                        mark.pixel.y,
                        picture.width_px,
                        picture.height_px));
      }
    }
  }
  return marks;
}

std::string AsText(const std::vector<NumberedMark>& marks, const ShadowEdgeFit& fit) {
  std::string text;
  if (fit.used == 0) {
    text = "no mark sees an outline of the mesh near the sun\n";
  } else {
    text = fmt::format(
        "real shadows and the computed sun differ by {:.2f} deg rms, {:.2f} deg at most, at {} "
        "marks\n",
        DegFromRad(fit.rms_rad),
        DegFromRad(fit.largest_rad),
        fit.used);
  }
  if (fit.azimuth_offset_rad) {
    text += fmt::format(
        "north offset {:+.2f} deg, sigma {:.2f} deg; with it they differ by {:.2f} deg rms\n",
        -DegFromRad(*fit.azimuth_offset_rad),
        DegFromRad(fit.azimuth_stddev_rad),
        DegFromRad(fit.rms_after_rad));
  }
  text += "frame       x       y   angle\n";
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const glm::dvec2& pixel = marks[i].mark.pixel;
    text += fmt::format("{:>5} {:>7.1f} {:>7.1f}  ", marks[i].frame, pixel.x, pixel.y);
    text += fit.angle_rad[i] ? fmt::format("{:.2f} deg\n", DegFromRad(*fit.angle_rad[i]))
                             : std::string("on no surface, or far from any shadow's edge\n");
  }
  return text;
}

std::string AsJson(const std::vector<NumberedMark>& marks, const ShadowEdgeFit& fit) {
  Json json;
  json["used"] = fit.used;
  json["rms_deg"] = fit.used > 0 ? Json(DegFromRad(fit.rms_rad)) : Json();
  json["largest_deg"] = fit.used > 0 ? Json(DegFromRad(fit.largest_rad)) : Json();
  const bool turned = fit.azimuth_offset_rad.has_value();
  json["north_offset_deg"] = turned ? Json(-DegFromRad(*fit.azimuth_offset_rad)) : Json();
  json["stddev_deg"] = turned ? Json(DegFromRad(fit.azimuth_stddev_rad)) : Json();
  json["rms_after_deg"] = turned ? Json(DegFromRad(fit.rms_after_rad)) : Json();
  json["marks"] = Json::array();
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const glm::dvec2& pixel = marks[i].mark.pixel;
    json["marks"].push_back(
        {{"frame", marks[i].frame},
         {"pixel", {pixel.x, pixel.y}},
         {"angle_deg", fit.angle_rad[i] ? Json(DegFromRad(*fit.angle_rad[i])) : Json()}});
  }
  return json.dump(2);
}

}  // namespace

std::string ReportShadowEdges(const Sequence& sequence,
                              FrameKind frames,
                              const std::filesystem::path& marks_file,
                              double stated_north_rad,
                              bool json) {
  const std::vector<NumberedMark> marks = ReadMarks(sequence, frames, marks_file, stated_north_rad);
  const RayCaster mesh(LoadMesh(sequence.folder / sequence.scene_mesh).mesh);
  std::vector<ShadowEdgeMark> plain;
  plain.reserve(marks.size());
  for (const NumberedMark& mark : marks) plain.push_back(mark.mark);
  const ShadowEdgeFit fit = FitShadowEdges(mesh, plain);
  return json ? AsJson(marks, fit) : AsText(marks, fit);
}

}  // namespace pleinair
