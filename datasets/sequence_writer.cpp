// sequence.json out.
#include "datasets/internal/sequence_json.h"

#include <string>
#include <vector>

#include "datasets/site_file.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

Json FromVector(const glm::dvec2& v) { return {v.x, v.y}; }
Json FromVector(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

template <typename Vector>
Json FromPolygon(const std::vector<Vector>& polygon) {
  Json corners = Json::array();
  for (const Vector& corner : polygon) corners.push_back(FromVector(corner));
  return corners;
}

Json FromCamera(const Sequence& sequence) {
  Json json = JsonOf(sequence.intrinsics);
  if (sequence.camera_from_world) json["camera_from_world"] = JsonOf(*sequence.camera_from_world);
  if (sequence.pose_stddev_rad) json["pose_uncertain_deg"] = DegFromRad(*sequence.pose_stddev_rad);
  return json;
}

Json FromEnvironment(const EnvironmentEntry& environment) {
  Json json = {{"image", environment.image.string()},
               {"position_m", FromVector(environment.position_m)},
               {"time_utc", FormatUtcTime(environment.time)}};
  if (environment.sun_direction_enu) {
    json["sun_direction_enu"] = FromVector(*environment.sun_direction_enu);
  }
  json["mapping"] = {
      {"type", "equirectangular"}, {"up", "+Z"}, {"center", "+Y (north)"}, {"right", "+X (east)"}};
  return json;
}

Json FromFisheye(const FisheyeEntry& fisheye) {
  Json json = {{"model", fisheye.model},
               {"fov_deg", fisheye.fov_deg},
               {"width", fisheye.width_px},
               {"height", fisheye.height_px}};
  if (!fisheye.up.empty()) json["up"] = fisheye.up;
  if (!fisheye.image_up.empty()) json["image_up"] = fisheye.image_up;
  if (!fisheye.image_right.empty()) json["image_right"] = fisheye.image_right;
  if (fisheye.position_m) json["position_m"] = FromVector(*fisheye.position_m);
  if (fisheye.calibration) json["calibration"] = fisheye.calibration->string();
  return json;
}

Json FromSamplePolygon(const SamplePolygon& polygon) {
  return {{"material", polygon.material},
          {"group", polygon.group},
          {"sun", NameOf(polygon.sun)},
          {"polygon_px", FromPolygon(polygon.polygon_px)}};
}

Json FromRaw(const RawImageEntry& raw) {
  return {{"image", raw.image.string()},
          {"format", NameOf(raw.format)},
          {"stride_bytes", raw.stride_bytes},
          {"black_level", raw.development.black_level},
          {"white_level", raw.development.white_level},
          {"white_balance_rgb", FromVector(raw.development.white_balance_rgb)}};
}

}  // namespace

Json JsonOf(const FrameEntry& frame) {
  Json json = Json::object();
  if (frame.image) json["image"] = frame.image->string();
  if (frame.image_ldr) json["image_ldr"] = frame.image_ldr->string();
  if (frame.video_frame) json["video_frame"] = *frame.video_frame;
  if (frame.raw) json["raw"] = FromRaw(*frame.raw);
  if (frame.fisheye) json["fisheye"] = frame.fisheye->string();
  json["time_utc"] = FormatUtcTime(frame.time);
  if (frame.exposure) json["exposure"] = *frame.exposure;
  if (frame.exposure_s) json["exposure_s"] = *frame.exposure_s;
  if (frame.iso) json["iso"] = *frame.iso;
  if (frame.f_number) json["f_number"] = *frame.f_number;
  if (frame.camera_from_world) json["camera_from_world"] = JsonOf(*frame.camera_from_world);
  if (frame.sun_direction_enu) json["sun_direction_enu"] = FromVector(*frame.sun_direction_enu);
  if (frame.weather) json["weather"] = NameOf(*frame.weather);
  if (!frame.sample_polygons.empty()) {
    Json& polygons = json["sample_polygons"] = Json::array();
    for (const SamplePolygon& polygon : frame.sample_polygons) {
      polygons.push_back(FromSamplePolygon(polygon));
    }
  }
  return json;
}

Json JsonOf(const VirtualObjectEntry& object) {
  return {{"mesh", object.mesh.string()}, {"world_from_object", JsonOf(object.world_from_object)}};
}

Json JsonOf(const Sequence& sequence) {
  Json json = {{"format", "pleinair-sequence"}, {"version", 1}};
  if (!sequence.name.empty()) json["name"] = sequence.name;
  if (sequence.site) {
    json["site"] = {{"latitude_deg", DegFromRad(sequence.site->latitude_rad)},
                    {"longitude_deg", DegFromRad(sequence.site->longitude_rad)},
                    {"height_m", sequence.site->height_m}};
    if (sequence.north_stddev_rad > 0.0) {
      json["site"]["north_uncertain_deg"] = DegFromRad(sequence.north_stddev_rad);
    }
  }
  if (sequence.weather) json["weather"] = NameOf(*sequence.weather);
  json["camera"] = FromCamera(sequence);
  if (!sequence.camera_device.empty()) json["camera_device"] = sequence.camera_device;
  json["radiometry"] = {{"frames", "linear"}, {"frames_ldr", sequence.response_ldr}};
  json["scene"] = {{"mesh", sequence.scene_mesh.string()},
                   {"albedos_known", sequence.albedos_known},
                   {"albedos_assumed", sequence.albedos_assumed}};
  for (const WindowEntry& window : sequence.windows) {
    Json entry = {{"polygon_world_m", FromPolygon(window.polygon_world_m)}};
    if (!window.name.empty()) entry["name"] = window.name;
    json["windows"].push_back(std::move(entry));
  }
  if (!sequence.diffuse_regions.empty()) json["diffuse_regions"] = sequence.diffuse_regions;
  if (sequence.diffuse_mask) json["diffuse_mask"] = sequence.diffuse_mask->string();
  if (sequence.environment) {
    json["environment"] = FromEnvironment(*sequence.environment);
  } else if (sequence.sun_direction_enu) {
    json["environment"] = {{"sun_direction_enu", FromVector(*sequence.sun_direction_enu)}};
  }
  if (sequence.fisheye) json["fisheye"] = FromFisheye(*sequence.fisheye);
  for (const VirtualObjectEntry& object : sequence.virtual_objects) {
    json["virtual_objects"].push_back(JsonOf(object));
  }
  json["frames"] = Json::array();
  for (const FrameEntry& frame : sequence.frames) json["frames"].push_back(JsonOf(frame));
  return json;
}

void WriteSequenceJson(const Json& json, const std::filesystem::path& folder) {
  WriteJsonFile(json, folder / "sequence.json");
}

void WriteSequence(const Sequence& sequence, const std::filesystem::path& folder) {
  WriteSequenceJson(JsonOf(sequence), folder);
}

}  // namespace pleinair
