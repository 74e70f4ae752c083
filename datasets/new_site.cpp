#include "datasets/new_site.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "calib/exif_lens.h"
#include "calib/json_cursor.h"
#include "calib/timed_pose.h"
#include "datasets/internal/sequence_json.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "datasets/site_objects.h"
#include "scene/image_io.h"
#include "scene/mesh_io.h"
#include "scene/mesh_writer.h"
#include "scene/whole_file.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kMeshNote = "note_mesh";
constexpr const char* kMapNote = "note_environment";

bool Has(const Json& json, const char* object, const char* key) {
  return json.contains(object) && json[object].is_object() && json[object].contains(key);
}

// A name in the folder that is not taken: NAME.EXT, NAME-2.EXT, ...
fs::path FreeName(const fs::path& folder, const std::string& stem, const std::string& extension) {
  for (int number = 1;; ++number) {
    fs::path name = (number == 1 ? stem : fmt::format("{}-{}", stem, number)) + extension;
    std::error_code error;
    if (!fs::exists(folder / name, error)) return name;
  }
}

// Notes in the site's file on which file of the folder is made here, so that the next one replaces
// it and no file of a person.
std::string MadeNote(const fs::path& name) { return name.string() + " is made by site new"; }

// Where the site's file names a file, and the key of the note on it.
struct FileEntry {
  const char* object;
  const char* key;
  const char* note;
};

// The file that the entry names, where it was written by this module; never `source`.
std::optional<fs::path> MadeBefore(const fs::path& folder,
                                   const Json& json,
                                   const FileEntry& entry,
                                   const fs::path& source) {
  const auto& [object, key, note] = entry;
  if (!Has(json, object, key) || !json[object][key].is_string()) return std::nullopt;
  const fs::path name = json[object][key].get<std::string>();
  std::error_code error;
  if (json.value(note, Json()) != MadeNote(name) || name.has_parent_path() ||
      fs::equivalent(folder / name, source, error)) {
    return std::nullopt;
  }
  return folder / name;
}

void RemoveMesh(fs::path file) {
  std::error_code ignored;
  fs::remove(file, ignored);
  fs::remove(file.replace_extension(".mtl"), ignored);
}

bool HasGroupOrMaterial(const Mesh& mesh, const std::string& name) {
  return std::find(mesh.group_names.begin(), mesh.group_names.end(), name) !=
             mesh.group_names.end() ||
         std::any_of(mesh.materials.begin(), mesh.materials.end(), [&](const Material& material) {
           return material.name == name;
         });
}

// Takes those names from diffuse_regions that the mesh lacks, and returns them.
std::vector<std::string> DropUnknownRegions(const Mesh& mesh, Json& json) {
  std::vector<std::string> dropped;
  Json kept = Json::array();
  for (const Json& name : json.value("diffuse_regions", Json::array())) {
    if (name.is_string() && !HasGroupOrMaterial(mesh, name.get<std::string>())) {
      dropped.push_back(name.get<std::string>());
    } else {
      kept.push_back(name);
    }
  }
  if (dropped.empty()) return dropped;
  if (kept.empty()) {
    json.erase("diffuse_regions");
  } else {
    json["diffuse_regions"] = std::move(kept);
  }
  return dropped;
}

// In the file's list, or in the file that it names, which has an entry in each line.
bool FramesHavePoses(const fs::path& file, const Json& json) {
  const auto has_pose = [](const Json& frame) {
    return frame.is_object() && frame.contains("camera_from_world");
  };
  const Json frames = json.value("frames", Json::array());
  if (!frames.is_string()) return std::any_of(frames.begin(), frames.end(), has_pose);
  std::ifstream lines(file.parent_path() / frames.get<std::string>(), std::ios::binary);
  for (std::string line; std::getline(lines, line);) {
    if (has_pose(Json::parse(line, nullptr, false))) return true;
  }
  return false;
}

std::string SizeText(const Mesh& mesh) {
  const BoundingBox box = BoundingBoxOf(mesh);
  const glm::vec3 size = box.upper_m - box.lower_m;
  return fmt::format("{:.4g} x {:.4g} x {:.4g} m", size.x, size.y, size.z);
}

std::string Joined(const std::vector<std::string>& names) {
  constexpr std::size_t kMostNames = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  return names.size() > kMostNames ? text + ", ..." : text;
}

std::optional<std::string> MeshState(const fs::path& folder, const Json& json) {
  if (!Has(json, "scene", "mesh") || !json["scene"]["mesh"].is_string()) return std::nullopt;
  const fs::path file = json["scene"]["mesh"].get<std::string>();
  const Mesh mesh = LoadMesh(folder / file).mesh;
  return fmt::format("{}: {}, groups {}", file.string(), SizeText(mesh), Joined(mesh.group_names));
}

std::optional<std::string> AlbedoState(const Json& json) {
  if (Has(json, "environment", "image")) {
    return "environment map " + json["environment"]["image"].dump();
  }
  for (const char* key : {"albedos_known", "albedos_assumed"}) {
    if (Has(json, "scene", key) && json["scene"][key] == true) {
      return std::string("the materials' Kd, ") + (key[8] == 'k' ? "measured" : "guessed");
    }
  }
  return std::nullopt;
}

std::optional<std::string> ObjectsState(const Json& json) {
  std::string text;
  const auto add = [&](const Json& object) {
    if (!object.contains("mesh") || !object["mesh"].is_string()) return;
    text += (text.empty() ? "" : ", ") + object["mesh"].get<std::string>();
  };
  if (json.contains("virtual_object")) add(json["virtual_object"]);
  for (const Json& object : json.value("virtual_objects", Json::array())) add(object);
  if (text.empty()) return std::nullopt;
  return text;
}

// By its size and EXIF focal length; says so in `note`.
CameraIntrinsics LensOfPhoto(const fs::path& file, const Rgb8Image& photo, Json& note) {
  const auto focal_mm = ReadExifFocalLength35mm(file);
  if (!focal_mm) {
    RefuseFile(file,
               "expected EXIF data with the focal length for 35 mm film; calibrate the lens: "
               "pleinair calibrate lens");
  }
  // Diagonal of 36 x 24 mm.
  constexpr double kFilmDiagonalMm = 43.27;
  CameraIntrinsics lens;
  lens.width_px = photo.width;
  lens.height_px = photo.height;
  lens.fx_px = lens.fy_px = *focal_mm / kFilmDiagonalMm * std::hypot(photo.width, photo.height);
  lens.cx_px = 0.5 * (photo.width - 1);
  lens.cy_px = 0.5 * (photo.height - 1);
  note = fmt::format("from EXIF data: {:g} mm for 35 mm film", *focal_mm);
  return lens;
}

}  // namespace

glm::dmat4 MeshFrame::MetresZUpFromFile() const {
  glm::dmat4 turn(1.0);
  if (y_is_up) {
    // Y becomes Z, and Z, towards the viewer, south.
    turn[1] = {0.0, 0.0, 1.0, 0.0};
    turn[2] = {0.0, -1.0, 0.0, 0.0};
  }
  return glm::scale(glm::dmat4(1.0), glm::dvec3(unit_m)) * turn;
}

double MetresOfUnit(const std::string& unit) {
  constexpr std::pair<const char*, double> kUnits[] = {
      {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"ft", 0.3048}, {"in", 0.0254}};
  for (const auto& [name, metres] : kUnits) {
    if (unit == name) return metres;
  }
  throw std::invalid_argument("unit '" + unit + "': expected m, cm, mm, ft or in");
}

std::vector<SitePartState> SitePartsIn(const fs::path& folder) {
  const fs::path file = SiteFileIn(folder);
  LoadJson(file);
  const std::vector<std::byte> bytes = ReadWholeFile(file);
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const Json json = Json::parse(text, text + bytes.size());
  const std::string new_site = "pleinair site new " + folder.string();
  const auto number = [](const Json& value) {
    return value.is_number() ? value.get<double>() : 0.0;
  };

  std::optional<std::string> place;
  if (Has(json, "site", "latitude_deg") && Has(json, "site", "longitude_deg")) {
    const Json& at = json["site"];
    place = fmt::format("{:.6g}, {:.6g} deg, {:.4g} m",
                        number(at["latitude_deg"]),
                        number(at["longitude_deg"]),
                        number(at.value("height_m", Json(0.0))));
  }
  std::optional<std::string> device;
  if (json.contains("camera_device")) device = json["camera_device"].get<std::string>();
  std::optional<std::string> lens;
  if (Has(json, "camera", "width") && Has(json, "camera", "fx")) {
    const Json& at = json["camera"];
    lens = fmt::format(
        "{:g}x{:g} pixels, fx {:.6g}{}",
        number(at["width"]),
        number(at["height"]),
        number(at["fx"]),
        json.contains("note_lens") ? " (from EXIF data, to some 3 %: better calibrate it)" : "");
  }
  std::optional<std::string> pose;
  if (Has(json, "camera", "camera_from_world")) pose = "stated";
  return {
      {SitePart::kPlace,
       "place",
       place,
       true,
       "latitude and longitude from a map, to 0.01 deg or better",
       new_site + " --place LAT,LON[,H]"},
      {SitePart::kMesh,
       "mesh",
       MeshState(folder, json),
       true,
       "walls and ground as OBJ, PLY or glTF, with +X east and +Y north: from a plan, or from "
       "photographs by a reconstruction",
       new_site + " --mesh FILE [--mesh-units m|cm|mm|ft] [--mesh-up z|y]"},
      {SitePart::kCamera,
       "camera",
       device,
       false,
       "for live runs a device or identity, as `pleinair cameras` lists it; for photographs one of "
       "them",
       new_site + " --camera DEVICE|PHOTO"},
      {SitePart::kLens,
       "lens",
       lens,
       true,
       "from pictures of a chessboard (pleinair calibrate lens), or roughly from the EXIF data of "
       "a "
       "photograph (--camera PHOTO)",
       new_site + " --lens FILE"},
      {SitePart::kPose,
       "pose",
       pose,
       true,
       "from points that mesh and picture both show (pleinair calibrate pose), or roughly by "
       "--camera-at X,Y,Z --camera-to X,Y,Z",
       new_site + " --pose FILE"},
      {SitePart::kAlbedo,
       "albedo",
       AlbedoState(json),
       false,
       "a lat-long HDR picture of the place; or that the mesh's Kd is measured or guessed "
       "(--albedos known|assumed)",
       new_site + " --environment FILE --environment-at X,Y,Z --environment-time UTC"},
      {SitePart::kObjects,
       "objects",
       ObjectsState(json),
       false,
       "an OBJ or glTF",
       new_site + " --object FILE --object-at X,Y,Z"}};
}

void StartSite(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    RefuseFile(folder, "expected a folder, or the name of one that can be made");
  }
  if (fs::exists(folder / "site.json") || fs::exists(folder / "sequence.json")) {
    SiteFileIn(folder);
    return;
  }
  WriteJsonFile({{"format", "pleinair-site"}, {"version", 1}}, folder / "site.json");
}

void SetSitePlace(const fs::path& folder, const Site& site) {
  site.Validate();
  EditSiteFile(folder, [&](Json& json) {
    json["site"]["latitude_deg"] = DegFromRad(site.latitude_rad);
    json["site"]["longitude_deg"] = DegFromRad(site.longitude_rad);
    json["site"]["height_m"] = site.height_m;
  });
}

std::vector<std::string> SetSiteMesh(const fs::path& folder,
                                     const fs::path& mesh,
                                     const MeshFrame& frame) {
  const Mesh converted = TransformMesh(frame.MetresZUpFromFile(), LoadMesh(mesh).mesh);
  const fs::path name = FreeName(folder, "scene", ".obj");
  std::optional<fs::path> replaced;
  std::vector<std::string> dropped;
  try {
    WriteObj(converted, folder / name);
    const Mesh written = LoadMesh(folder / name).mesh;
    EditSiteFile(folder, [&](Json& json) {
      replaced = MadeBefore(folder, json, {"scene", "mesh", kMeshNote}, mesh);
      json["scene"]["mesh"] = name.string();
      json[kMeshNote] = MadeNote(name);
      dropped = DropUnknownRegions(written, json);
    });
  } catch (...) {
    RemoveMesh(folder / name);
    throw;
  }
  if (replaced) RemoveMesh(*replaced);
  return dropped;
}

void SetDiffuseRegions(const fs::path& folder, const std::vector<std::string>& names) {
  EditSiteFile(folder, [&](Json& json) {
    if (!Has(json, "scene", "mesh")) {
      throw std::runtime_error("diffuse regions: expected the mesh first, whose groups they name");
    }
    const Mesh mesh = LoadMesh(folder / json["scene"]["mesh"].get<std::string>()).mesh;
    for (const std::string& name : names) {
      if (HasGroupOrMaterial(mesh, name)) continue;
      throw std::runtime_error("diffuse region '" + name +
                               "': expected a group or material of the "
                               "mesh: " +
                               Joined(mesh.group_names));
    }
    json["diffuse_regions"] = names;
  });
}

SiteLens SetSiteCamera(const fs::path& folder, const std::string& device_or_photo) {
  std::error_code error;
  if (!fs::is_regular_file(device_or_photo, error)) {
    EditSiteFile(folder, [&](Json& json) { json["camera_device"] = device_or_photo; });
    return SiteLens::kAsAsked;
  }
  const Rgb8Image photo = ReadDisplayImage(device_or_photo);
  SiteLens outcome = SiteLens::kAsAsked;
  EditSiteFile(folder, [&](Json& json) {
    const bool has_lens = Has(json, "camera", "fx");
    if (has_lens && !json.contains("note_lens")) {
      outcome = SiteLens::kKept;  // A calibrated one is better.
      return;
    }
    const Json before = has_lens ? json["camera"] : Json();
    json["camera"].merge_patch(JsonOf(LensOfPhoto(device_or_photo, photo, json["note_lens"])));
    if (has_lens && json["camera"] != before) outcome = SiteLens::kReplaced;
  });
  return outcome;
}

void SetSiteLens(const fs::path& folder, const CameraIntrinsics& lens) {
  EditSiteFile(folder, [&](Json& json) {
    json["camera"].merge_patch(JsonOf(lens));
    json.erase("note_lens");
  });
}

void SetSitePose(const fs::path& folder,
                 const glm::dmat4& camera_from_world,
                 std::optional<double> stddev_rad,
                 const fs::path& out) {
  if (const std::string fault = FaultOfPose(camera_from_world); !fault.empty()) {
    throw std::invalid_argument("camera_from_world: expected " + fault);
  }
  const fs::path file = SiteFileIn(folder);
  EditSiteFile(
      file,
      [&](Json& json) {
        if (FramesHavePoses(file, json)) {
          RefuseFile(file,
                     "expected a camera that stands still, found frames with camera_from_world of "
                     "their own, which would be used instead");
        }
        json["camera"]["camera_from_world"] = JsonOf(camera_from_world);
        if (stddev_rad) {
          json["camera"]["pose_uncertain_deg"] = DegFromRad(*stddev_rad);
        } else {
          json["camera"].erase("pose_uncertain_deg");
        }
      },
      out);
}

void SetSiteEnvironment(const fs::path& folder,
                        const fs::path& map,
                        const glm::dvec3& position_m,
                        UtcTime time) {
  const RgbImage radiance = ReadRadianceImage(map);
  if (radiance.width != 2 * radiance.height) {
    throw std::runtime_error(
        fmt::format("{}: expected a lat-long picture, twice as wide as high, "
                    "found {}x{}",
                    map.string(),
                    radiance.width,
                    radiance.height));
  }
  const fs::path name = FreeName(folder, "environment", map.extension().string());
  WriteWholeFile(folder / name, ReadWholeFile(map));
  std::error_code ignored;
  std::optional<fs::path> replaced;
  try {
    EditSiteFile(folder, [&](Json& json) {
      replaced = MadeBefore(folder, json, {"environment", "image", kMapNote}, map);
      json[kMapNote] = MadeNote(name);
      json["environment"] = {{"image", name.string()},
                             {"position_m", {position_m.x, position_m.y, position_m.z}},
                             {"time_utc", FormatUtcTime(time)}};
    });
  } catch (...) {
    fs::remove(folder / name, ignored);
    throw;
  }
  if (replaced) fs::remove(*replaced, ignored);
}

void SetSiteAlbedos(const fs::path& folder, bool known) {
  EditSiteFile(folder, [&](Json& json) {
    json["scene"]["albedos_known"] = known;
    json["scene"]["albedos_assumed"] = !known;
  });
}

void AddSiteObject(const fs::path& folder,
                   const fs::path& mesh,
                   const MeshFrame& frame,
                   const glm::dvec3& at_m,
                   double turn_rad) {
  LoadMesh(mesh);
  VirtualObjectEntry object;
  object.mesh = BringObjectFile(folder, mesh);
  object.world_from_object = glm::translate(glm::dmat4(1.0), at_m) *
                             glm::rotate(glm::dmat4(1.0), turn_rad, glm::dvec3(0.0, 0.0, 1.0)) *
                             frame.MetresZUpFromFile();
  EditSiteFile(folder, [&](Json& json) {
    Json objects = json.value("virtual_objects", Json::array());
    if (json.contains("virtual_object")) {
      objects.push_back(json["virtual_object"]);
      json.erase("virtual_object");
    }
    const Json entry = JsonOf(object);
    if (std::find(objects.begin(), objects.end(), entry) == objects.end()) objects.push_back(entry);
    json["virtual_objects"] = std::move(objects);
  });
}

}  // namespace pleinair
