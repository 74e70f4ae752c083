#include "apps/calibrate_north_command.h"

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/shadow_edges_report.h"
#include "datasets/sequence.h"
#include "pipeline/sun_state.h"
#include "scene/mesh_io.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

const char* NameOf(NorthKind kind) {
  switch (kind) {
    case NorthKind::kGrid:
      return "grid";
    case NorthKind::kMagnetic:
      return "magnetic";
    case NorthKind::kTrue:
      break;
  }
  return "true";
}

// Stated azimuth of the model's +Y.
double StatedNorthAzimuthRad(const CalibrateNorthOptions& options, const Sequence& sequence) {
  if (options.model_north == NorthKind::kTrue) return 0.0;
  if (!sequence.site) {
    throw std::runtime_error(sequence.file.string() +
                             ": site is missing: expected for a grid or magnetic north");
  }
  return options.model_north == NorthKind::kGrid
             ? GridNorthAzimuthRad(*sequence.site)
             : MagneticNorthAzimuthRad(
                   *sequence.site, sequence.frames.front().time, options.magnetic);
}

// The sun turns one way in the model's frame as the model's north turns the other.
double NorthOffsetDeg(const ShadowDirection& shadow) {
  return -DegFromRad(shadow.azimuth_offset_rad);
}

std::string Advice(const ShadowDirection& shadow) {
  const double offset_deg = NorthOffsetDeg(shadow);
  if (!shadow.determined) {
    return "The pictures do not determine north: " + shadow.reason +
           ". Frames with sharp shadows of the mesh's own corners, hours apart, would help.";
  }
  if (!shadow.ContradictsTheSun())
    return "The model's north agrees with the pictures within their accuracy.";
  return fmt::format(
      "To correct it, turn mesh, objects and camera poses together about the vertical by {:.2f} "
      "deg "
      "{} (seen from above).",
      std::abs(offset_deg),
      offset_deg > 0.0 ? "clockwise" : "counter-clockwise");
}

std::string DescribeFrame(const FrameShadowDirection& frame) {
  if (!frame.sunlit) return fmt::format("{:>5}  {}", frame.frame, frame.shadow.reason);
  const std::string light = fmt::format(
      "{:>5}  lit : shaded {:>5.1f}, {:>3} parts", frame.frame, frame.contrast, frame.tiles);
  if (!frame.shadow.determined) return light + "  not determined: " + frame.shadow.reason;
  return fmt::format("{}  {:+6.2f} deg, sigma {:.2f}",
                     light,
                     NorthOffsetDeg(frame.shadow),
                     DegFromRad(frame.shadow.stddev_rad));
}

std::string AsText(const ShadowDirectionResult& result,
                   const CalibrateNorthOptions& options,
                   double stated_rad,
                   const std::vector<std::string>& bad_frames) {
  std::string text;
  if (result.all.determined) {
    text = fmt::format("north offset {:+.2f} deg, sigma {:.2f} deg\n",
                       NorthOffsetDeg(result.all),
                       DegFromRad(result.all.stddev_rad));
    text += fmt::format(
        "The model's +Y points to true azimuth {:.2f} deg; {} north was assumed ({:.2f} "
        "deg).\n",
        DegFromRad(stated_rad) + NorthOffsetDeg(result.all),
        NameOf(options.model_north),
        DegFromRad(stated_rad));
  } else {
    text = "north offset not determined\n";
  }
  text += Advice(result.all) + "\n";
  text += fmt::format(
      "sigma by agreement of parts {:.2f} deg, by leaving out frames and blocks {:.2f} deg\n",
      DegFromRad(result.all.curvature_stddev_rad),
      DegFromRad(result.all.spread_stddev_rad));
  text += "frame\n";
  for (const FrameShadowDirection& frame : result.frames) text += DescribeFrame(frame) + "\n";
  for (const std::string& bad : bad_frames) text += bad + "\n";
  return text;
}

Json ToJson(const ShadowDirection& shadow) {
  Json json;
  json["determined"] = shadow.determined;
  if (!shadow.determined) json["reason"] = shadow.reason;
  json["north_offset_deg"] = shadow.determined ? Json(NorthOffsetDeg(shadow)) : Json();
  json["stddev_deg"] = DegFromRad(shadow.stddev_rad);
  return json;
}

std::string AsJson(const ShadowDirectionResult& result,
                   const CalibrateNorthOptions& options,
                   double stated_rad,
                   const std::vector<std::string>& bad_frames) {
  Json json = ToJson(result.all);
  json["curvature_stddev_deg"] = DegFromRad(result.all.curvature_stddev_rad);
  json["spread_stddev_deg"] = DegFromRad(result.all.spread_stddev_rad);
  json["model_north"] = NameOf(options.model_north);
  json["model_north_azimuth_deg"] = DegFromRad(stated_rad);
  if (result.all.determined) {
    json["found_north_azimuth_deg"] = DegFromRad(stated_rad) + NorthOffsetDeg(result.all);
  }
  json["advice"] = Advice(result.all);
  json["frames"] = Json::array();
  for (const FrameShadowDirection& frame : result.frames) {
    Json one = {{"frame", frame.frame},
                {"sunlit", frame.sunlit},
                {"lit_to_shaded", frame.contrast},
                {"parts", frame.tiles}};
    one.update(ToJson(frame.shadow));
    json["frames"].push_back(std::move(one));
  }
  json["bad_frames"] = bad_frames;
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string RunCalibrateNorth(const CalibrateNorthOptions& options) {
  const Sequence sequence = ReadSequence(options.sequence);
  const double stated_rad = StatedNorthAzimuthRad(options, sequence);
  if (!options.shadow_edges.empty()) {
    return ReportShadowEdges(
        sequence, options.frames, options.shadow_edges, stated_rad, options.json);
  }
  ShadowDirectionFinder finder(LoadMesh(sequence.folder / sequence.scene_mesh).mesh,
                               sequence.diffuse_regions);
  const auto frames = MakeRecordedFrameSource(sequence, options.frames);
  std::vector<std::string> bad_frames;
  while (const auto frame = frames->Next()) {
    if (!*frame) {
      bad_frames.push_back(
          fmt::format("frame {} left out: {}", frame->error().index, frame->error().reason));
      continue;
    }
    const SunState sun = SunOfFrame(sequence.site, **frame);
    finder.Add(**frame, TurnedClockwise(sun.direction_enu, -stated_rad));
  }
  const ShadowDirectionResult result = finder.Result();
  if (result.frames.empty()) {
    throw std::runtime_error("no frame of " + sequence.folder.string() + " could be read" +
                             (bad_frames.empty() ? "" : ": " + bad_frames.front()));
  }
  return options.json ? AsJson(result, options, stated_rad, bad_frames)
                      : AsText(result, options, stated_rad, bad_frames);
}

std::string DescribeShadowDirection(const ShadowDirection& shadow) {
  if (!shadow.determined)
    return "the real shadows do not determine where the sun is: " + shadow.reason;
  return fmt::format(
      "real and virtual shadows on level ground differ by {:+.2f} deg (sigma {:.2f})",
      DegFromRad(shadow.azimuth_offset_rad),
      DegFromRad(shadow.stddev_rad));
}

}  // namespace pleinair
