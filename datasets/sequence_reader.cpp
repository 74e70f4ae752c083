// sequence.json in: every key checked for presence, type and range.
#include <array>
#include <functional>
#include <map>
#include <stdexcept>

#include "calib/json_cursor.h"
#include "datasets/fisheye_setup.h"
#include "datasets/internal/frame_entries.h"
#include "datasets/internal/json_vectors.h"
#include "datasets/internal/sequence_file.h"
#include "datasets/internal/sequence_folder.h"
#include "datasets/internal/sequence_values.h"
#include "datasets/sequence.h"
#include "datasets/site_file.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

class SequenceReader {
 public:
  SequenceReader(const std::filesystem::path& file,
                 SequencePoses poses,
                 std::optional<Weather> weather)
      : folder_(file.parent_path()), poses_(poses), weather_(weather) {
    sequence_.folder = folder_;
    sequence_.file = file;
  }

  Sequence Read(const JsonCursor& root) {
    ReadPlace(root);
    ReadFrames(root);
    if (weather_) {
      sequence_.weather = weather_;
      for (FrameEntry& frame : sequence_.frames) frame.weather.reset();
    }
    CheckFisheye(root);
    CheckSunIsKnown();
    return std::move(sequence_);
  }

  // Without frames but the one that says where the camera stands.
  Sequence ReadSite(const JsonCursor& root, UtcTime time) {
    ReadPlace(root);
    // Weather is of the day that was recorded.
    sequence_.weather = weather_;
    if (root.Optional("frames") && !sequence_.camera_from_world) {
      ReadFrames(root);
      sequence_.camera_from_world = sequence_.frames.front().camera_from_world;
      sequence_.frames.clear();
    }
    sequence_.frames.emplace_back().time = time;
    if (!sequence_.camera_from_world && poses_ == SequencePoses::kRequired) {
      root.Required("camera").FailMissing(
          "camera_from_world",
          "where the camera stands (`calibrate pose`); of one that moves, "
          "roughly (`site new --camera-at --camera-to`)");
    }
    CheckFisheye(root);
    CheckSunIsKnown();
    return std::move(sequence_);
  }

 private:
  // All but the frames.
  void ReadPlace(const JsonCursor& root) {
    const bool is_site =
        root.Required("format").OneOf({"pleinair-sequence", "pleinair-site"}) == "pleinair-site";
    root.Required("version").IntegerIn(1, 1);
    root.CheckKeys({"format",
                    "version",
                    "site",
                    "weather",
                    "camera",
                    "camera_device",
                    "radiometry",
                    "scene",
                    "windows",
                    "diffuse_regions",
                    "diffuse_mask",
                    "environment",
                    "fisheye",
                    "virtual_object",
                    "virtual_objects",
                    "frames"});
    for (const char* key : {"weather", "frames"}) {
      const auto of_a_recording = root.Optional(key);
      if (is_site && of_a_recording) of_a_recording->Fail("a site, which has no such key");
    }
    if (const auto name = root.Optional("name")) sequence_.name = name->FreeText();
    if (sequence_.name.empty()) sequence_.name = DefaultName();
    if (const auto at = root.Optional("site")) ReadSite(*at);
    sequence_.weather = ReadOptional(root, "weather", ReadWeather);
    const JsonCursor camera = root.Required("camera");
    sequence_.intrinsics = ReadIntrinsics(camera);
    sequence_.camera_from_world = ReadOptional(camera, "camera_from_world", ReadRigid);
    sequence_.pose_stddev_rad = ReadPoseStddevRad(camera);
    if (const auto at = root.Optional("camera_device")) sequence_.camera_device = at->Text();
    if (const auto at = root.Optional("radiometry")) ReadRadiometry(*at);
    ReadScene(root.Required("scene"));
    if (const auto at = root.Optional("windows")) ReadWindows(*at);
    if (const auto at = root.Optional("diffuse_regions")) {
      sequence_.diffuse_regions = ReadTexts(*at);
      if (sequence_.diffuse_regions.empty()) at->Fail("at least one name, or no such key for all");
    }
    if (const auto at = root.Optional("diffuse_mask")) sequence_.diffuse_mask = ExistingFile(*at);
    if (const auto at = root.Optional("environment")) ReadEnvironment(*at);
    if (const auto at = root.Optional("fisheye")) sequence_.fisheye = ReadFisheye(*at);
    ReadVirtualObjects(root);
  }

  std::string DefaultName() const {
    std::error_code error;
    return std::filesystem::canonical(folder_, error).filename().string();
  }

  std::filesystem::path ExistingFile(const JsonCursor& at) const {
    return ReadExistingFile(at, folder_);
  }

  void ReadSite(const JsonCursor& at) {
    at.CheckKeys({"latitude_deg", "longitude_deg", "height_m", "north_uncertain_deg"});
    Site& site = sequence_.site.emplace();
    site.latitude_rad = RadFromDeg(at.Required("latitude_deg").NumberIn(-90.0, 90.0));
    site.longitude_rad = RadFromDeg(at.Required("longitude_deg").NumberIn(-360.0, 360.0));
    // From below the lowest shore to the highest orbits that cameras have worked in.
    site.height_m = at.Required("height_m").NumberIn(-1000.0, 1e6);
    if (const auto uncertain = at.Optional("north_uncertain_deg")) {
      sequence_.north_stddev_rad = RadFromDeg(uncertain->NumberIn(0.0, 180.0));
    }
  }

  void ReadRadiometry(const JsonCursor& at) {
    at.CheckKeys({"frames", "frames_ldr"});
    if (const auto frames = at.Optional("frames")) frames->OneOf({"linear"});
    if (const auto ldr = at.Optional("frames_ldr")) {
      const bool srgb = ldr->Text() == "srgb8";
      sequence_.response_ldr = srgb ? "srgb8" : ExistingFile(*ldr).string();
    }
  }

  void ReadScene(const JsonCursor& at) {
    at.CheckKeys({"mesh", "albedos_known", "albedos_assumed"});
    sequence_.scene_mesh = ExistingFile(at.Required("mesh"));
    if (const auto known = at.Optional("albedos_known")) sequence_.albedos_known = known->Boolean();
    if (const auto assumed = at.Optional("albedos_assumed")) {
      sequence_.albedos_assumed = assumed->Boolean();
    }
  }

  void ReadWindows(const JsonCursor& at) {
    for (const JsonCursor& window : at.List(0, kAnyCount)) {
      window.CheckKeys({"polygon_world_m"});
      WindowEntry entry;
      if (const auto name = window.Optional("name")) entry.name = name->FreeText();
      for (const JsonCursor& corner : window.Required("polygon_world_m").List(3, kAnyCount)) {
        entry.polygon_world_m.push_back(ReadVector3(corner));
      }
      sequence_.windows.push_back(std::move(entry));
    }
  }

  void ReadEnvironment(const JsonCursor& at) {
    at.CheckKeys({"image", "position_m", "time_utc", "sun_direction_enu", "mapping"});
    const auto sun = ReadOptional(at, "sun_direction_enu", ReadDirection);
    if (const auto mapping = at.Optional("mapping")) CheckMapping(*mapping);
    const auto image = at.Optional("image");
    if (!image) {
      // Position and time have no use without a map; the sun may still be stated here.
      if (!sun) at.Fail("an object with `image` or `sun_direction_enu`");
      sequence_.sun_direction_enu = sun;
      return;
    }
    EnvironmentEntry entry;
    entry.image = ExistingFile(*image);
    entry.position_m = ReadVector3(at.Required("position_m"));
    entry.time = ReadTime(at.Required("time_utc"));
    entry.sun_direction_enu = sun;
    sequence_.environment = std::move(entry);
  }

  // A map that says it is laid out differently from scene/lat_long.h would be read turned or
  // mirrored.
  static void CheckMapping(const JsonCursor& at) {
    at.CheckKeys({"type", "up", "center", "right"});
    if (const auto type = at.Optional("type")) type->OneOf({"equirectangular"});
    if (const auto up = at.Optional("up")) up->OneOf({"+Z", "+Z (up)", "+Z up"});
    if (const auto center = at.Optional("center")) {
      center->OneOf({"+Y (north)", "+Y north", "+Y", "north"});
    }
    if (const auto right = at.Optional("right")) {
      right->OneOf({"+X (east)", "+X east", "+X", "east"});
    }
  }

  // Throws at the key that does not go with the others, or with the calibration.
  // Once the frames are read.
  void CheckFisheye(const JsonCursor& root) const {
    if (!sequence_.fisheye) return;
    const JsonCursor at = root.Required("fisheye");
    try {
      if (HasFisheyePictures(sequence_)) {
        MakeFisheyeSetup(*sequence_.fisheye, folder_);
      } else {
        CheckUnusedFisheye(*sequence_.fisheye, folder_);
      }
    } catch (const JsonError&) {
      throw;  // Names the calibration file.
    } catch (const std::exception& error) {
      throw JsonError(sequence_.file.string() + ": " + at.Path() + "." + error.what());
    }
  }

  FisheyeEntry ReadFisheye(const JsonCursor& at) const {
    at.CheckKeys({"model",
                  "fov_deg",
                  "width",
                  "height",
                  "up",
                  "image_up",
                  "image_right",
                  "position_m",
                  "calibration"});
    FisheyeEntry entry;
    entry.model =
        at.Required("model").OneOf({"equidistant", "equisolid", "stereographic", "opencv"});
    const auto fov = at.Required("fov_deg");
    entry.fov_deg = fov.PositiveNumber();
    if (entry.fov_deg > 360.0) fov.Fail("an angle of at most 360 degrees");
    entry.width_px = at.Required("width").IntegerIn(1, kMaxImageSidePx);
    entry.height_px = at.Required("height").IntegerIn(1, kMaxImageSidePx);
    if (const auto up = at.Optional("up")) entry.up = up->Text();
    if (const auto up = at.Optional("image_up")) entry.image_up = up->Text();
    if (const auto right = at.Optional("image_right")) entry.image_right = right->Text();
    entry.position_m = ReadOptional(at, "position_m", ReadVector3);
    if (const auto calibration = at.Optional("calibration")) {
      entry.calibration = ExistingFile(*calibration);
    } else if (entry.model == "opencv") {
      at.Required("calibration");
    }
    return entry;
  }

  VirtualObjectEntry ReadVirtualObject(const JsonCursor& at) const {
    at.CheckKeys({"mesh", "world_from_object"});
    VirtualObjectEntry entry;
    entry.mesh = ExistingFile(at.Required("mesh"));
    entry.world_from_object = ReadInvertible(at.Required("world_from_object"));
    return entry;
  }

  void ReadVirtualObjects(const JsonCursor& root) {
    const auto one = root.Optional("virtual_object");
    const auto several = root.Optional("virtual_objects");
    if (one && several) several->Fail("only one of `virtual_object` and `virtual_objects`");
    if (one) sequence_.virtual_objects.push_back(ReadVirtualObject(*one));
    if (!several) return;
    // Surfaces that coincide are never visible, and each ray that meets them tests all of them:
    // time would grow with the square of their number.
    std::map<std::pair<std::filesystem::path, std::array<double, 16>>, std::string> known;
    for (const JsonCursor& at : several->List(0, kAnyCount)) {
      VirtualObjectEntry entry = ReadVirtualObject(at);
      std::array<double, 16> place{};
      for (std::size_t i = 0; i < place.size(); ++i) {
        place[i] = entry.world_from_object[static_cast<int>(i / 4)][static_cast<int>(i % 4)];
      }
      const auto [same, is_new] = known.try_emplace({entry.mesh, place}, at.Path());
      if (!is_new) at.Fail("a mesh or a place of its own, other than those of " + same->second);
      sequence_.virtual_objects.push_back(std::move(entry));
    }
  }

  void ReadFrames(const JsonCursor& root) {
    const bool need_pose = !sequence_.camera_from_world && poses_ == SequencePoses::kRequired;
    sequence_.frames =
        ReadFrameEntries(root.Required("frames"),
                         {folder_, sequence_.file, sequence_.fisheye.has_value(), need_pose});
  }

  // A fish-eye camera and a survey map may show the sun; a photograph does not.
  void CheckSunIsKnown() const {
    if (sequence_.site || sequence_.fisheye || sequence_.environment) return;
    for (std::size_t i = 0; i < sequence_.frames.size(); ++i) {
      if (sequence_.StatedSunDirectionEnu(i) || sequence_.WeatherOfFrame(i) == Weather::kOvercast) {
        continue;
      }
      const std::string frame = "frames[" + std::to_string(i) + "]";
      std::string message = sequence_.file.string();
      message += ": site: expected latitude_deg, longitude_deg and height_m, or ";
      message += frame + ".sun_direction_enu, or \"overcast\" as ";
      message +=
          frame + ".weather (for all frames --weather overcast): nothing says where the sun is";
      throw JsonError(message);
    }
  }

  std::filesystem::path folder_;
  SequencePoses poses_;
  std::optional<Weather> weather_;
  Sequence sequence_;
};

namespace fs = std::filesystem;

Sequence ReadWith(const fs::path& file, const std::function<Sequence(const JsonCursor&)>& read) {
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  CheckFormat(root);
  return read(root);
}

}  // namespace

Sequence ReadSequence(const std::filesystem::path& folder,
                      SequencePoses poses,
                      std::optional<Weather> weather) {
  const fs::path file = SequenceFileIn(folder);
  return ReadWith(file, [&](const JsonCursor& root) {
    root.Required("format").OneOf({"pleinair-sequence"});
    return SequenceReader(file, poses, weather).Read(root);
  });
}

Sequence ReadSite(const std::filesystem::path& folder,
                  UtcTime time,
                  SequencePoses poses,
                  std::optional<Weather> weather) {
  std::error_code error;
  const fs::path site = folder / "site.json";
  const bool is_site = fs::exists(site, error);
  if (is_site && !ResolveInside(folder, "site.json")) {
    throw JsonError(site.string() + ": expected a file inside the site's folder");
  }
  const fs::path file = is_site ? site : SequenceFileIn(folder);
  return ReadWith(file, [&](const JsonCursor& root) {
    return SequenceReader(file, poses, weather).ReadSite(root, time);
  });
}

StatedCamera ReadStatedCamera(const std::filesystem::path& file_or_folder) {
  const fs::path file = SiteFileIn(file_or_folder);
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  CheckFormat(root);
  const JsonCursor camera = root.Required("camera");
  return {ReadIntrinsics(camera),
          ReadOptional(camera, "camera_from_world", ReadRigid),
          ReadPoseStddevRad(camera)};
}

CameraIntrinsics ReadCameraIntrinsics(const std::filesystem::path& file_or_folder) {
  return ReadStatedCamera(file_or_folder).intrinsics;
}

}  // namespace pleinair
