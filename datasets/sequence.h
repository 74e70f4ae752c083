// The sequence format, version 1: a folder with sequence.json, frames, mesh and environment.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "datasets/camera/camera_picture.h"
#include "datasets/camera/pixel_format.h"
#include "scene/camera.h"
#include "scene/frame.h"
#include "scene/utc_time.h"
#include "scene/weather.h"
#include "sunmodel/site.h"

namespace pleinair {

// A sensor's bytes as its driver delivered them: Bayer, without a header, of the camera's size.
struct RawImageEntry {
  std::filesystem::path image;
  PixelFormat format;
  int stride_bytes = 0;
  RawDevelopment development;
};

// Paths are relative to Sequence::folder.
struct FrameEntry {
  std::optional<std::filesystem::path> image;
  std::optional<std::filesystem::path> image_ldr;
  // The picture of a video file that image_ldr names, counted from 0 in the order of presentation.
  std::optional<int> video_frame;
  std::optional<RawImageEntry> raw;  // Replaces image and image_ldr.
  std::optional<std::filesystem::path> fisheye;
  UtcTime time{};
  std::optional<double> exposure;    // Linear factor from radiance to the 8-bit camera's [0, 1].
  std::optional<double> exposure_s;  // How long the shutter was open.
  std::optional<double> iso;
  std::optional<double> f_number;
  std::optional<glm::dmat4> camera_from_world;
  std::optional<glm::dvec3> sun_direction_enu;
  std::optional<Weather> weather;
  std::vector<SamplePolygon> sample_polygons;

  // `exposure`, or else t ISO / N^2 where the camera's metadata have all three; none: unknown.
  std::optional<double> EffectiveExposure() const;
};

// The survey map. Its image follows the one mapping of scene/lat_long.h.
struct EnvironmentEntry {
  std::filesystem::path image;
  glm::dvec3 position_m{0.0};
  UtcTime time{};
  std::optional<glm::dvec3> sun_direction_enu;
};

// The key `fisheye`.
struct FisheyeEntry {
  std::string model;  // equidistant, equisolid, stereographic, opencv
  double fov_deg = 180.0;
  int width_px = 0;
  int height_px = 0;
  // World axes in words ("+Y north"): the optical axis, and what is up and right in the picture.
  std::string up;
  std::string image_up;
  std::string image_right;
  std::optional<glm::dvec3> position_m;
  std::optional<std::filesystem::path> calibration;  // See calib/fisheye_file.h.
};

// An entry of `windows`; world frame, metres.
struct WindowEntry {
  std::string name;
  std::vector<glm::dvec3> polygon_world_m;
};

// An entry of `virtual_objects`; an invertible transform, metres.
struct VirtualObjectEntry {
  std::filesystem::path mesh;
  glm::dmat4 world_from_object{1.0};
};

// sequence.json. World frame: metres, east-north-up; camera frame: OpenCV's.
struct Sequence {
  std::filesystem::path folder;
  std::filesystem::path file;  // sequence.json or site.json in it, for messages.
  std::string name;
  std::optional<Site> site;
  // Standard deviation of the angle between the world frame's +Y and true north; 0: exact.
  double north_stddev_rad = 0.0;
  std::optional<Weather> weather;  // For all frames; a frame's own takes precedence.
  CameraIntrinsics intrinsics;
  std::string camera_device;  // For live runs: a device or a camera's identity; empty: not stated.
  std::optional<glm::dmat4> camera_from_world;  // A frame's own takes precedence.
  // Standard deviation of its rotation about each axis; 0: exact; none: not stated.
  std::optional<double> pose_stddev_rad;
  std::string response_ldr = "srgb8";  // Or the path of a response file.
  std::filesystem::path scene_mesh;
  bool albedos_known = false;
  bool albedos_assumed = false;
  std::vector<WindowEntry> windows;
  std::vector<std::string> diffuse_regions;  // Groups or materials; empty means all.
  std::optional<std::filesystem::path> diffuse_mask;
  std::optional<EnvironmentEntry> environment;
  // environment.sun_direction_enu of a sequence without a survey map.
  std::optional<glm::dvec3> sun_direction_enu;
  std::optional<FisheyeEntry> fisheye;
  std::vector<VirtualObjectEntry> virtual_objects;
  std::vector<FrameEntry> frames;

  // `name`, or the name of the folder where that is empty.
  std::string NameOrFolder() const;
  // False for a site.
  bool HasPictures() const;
  // Throws std::out_of_range; std::invalid_argument where neither frame nor sequence has a pose.
  Camera CameraOfFrame(std::size_t frame) const;
  // The frame's own direction, or without a site the environment's; none: it follows from place
  // and time.
  std::optional<glm::dvec3> StatedSunDirectionEnu(std::size_t frame) const;
  // The sun's direction for frames that do not state their own.
  std::optional<glm::dvec3> StatedSunDirectionEnu() const;
  // The frame's own, or the sequence's; none where neither is stated.
  std::optional<Weather> WeatherOfFrame(std::size_t frame) const;
};

// Whether each frame must have a pose, its own or the camera's. It need not where markers in the
// picture give it.
enum class SequencePoses { kRequired, kMayBeAbsent };

// Reads and checks `folder`/sequence.json: every key, type and range, every referenced file's
// presence except the frames' (a missing frame is that frame's failure, not the sequence's).
//
// Strictness  an unknown key is an error, except free ones (`name`, note..., formula..., world...);
//         a transform is rigid to 1e-5, a direction unit to 1e-3 (and then made unit);
//         camera.pixel_centers may be left out, and must be "integer" otherwise.
// Frames  where `frames` is the name of a file, it has an entry of the list in each line; a last
//         line without its end is ignored: a recorder was stopped there.
// Weather  `weather`, where given, is for all frames, and replaces values in the file.
// Sun     without a site, a survey map or a fish-eye camera, each frame states where the sun is, or
//         is overcast.
// Throws  std::runtime_error, one line with file, key and what was expected; for a video, a picture
//         or a folder of pictures, what a sequence is. Nothing outside the folder is read: a path
//         that leaves it (symbolic links included) is refused.
Sequence ReadSequence(const std::filesystem::path& folder,
                      SequencePoses poses = SequencePoses::kRequired,
                      std::optional<Weather> weather = std::nullopt);

// A site: what a sequence.json holds without its frames and weather, as `folder`/site.json
// ("format": "pleinair-site") or else as a sequence's own file. The camera stands where it says, or
// where the sequence's first frame says. `frames` then has one entry, without a picture, at `time`:
// the camera where it stands. Throws as ReadSequence.
Sequence ReadSite(const std::filesystem::path& folder,
                  UtcTime time,
                  SequencePoses poses = SequencePoses::kRequired,
                  std::optional<Weather> weather = std::nullopt);

// `camera` of a sequence.json or site.json, or of the one in a folder, which may be no sequence
// yet: of all other keys only `format` is read, where it exists. Throws as ReadSequence.
struct StatedCamera {
  CameraIntrinsics intrinsics;
  std::optional<glm::dmat4> camera_from_world;
  std::optional<double> pose_stddev_rad;  // As Sequence's.
};
StatedCamera ReadStatedCamera(const std::filesystem::path& file_or_folder);
// Only the lens.
CameraIntrinsics ReadCameraIntrinsics(const std::filesystem::path& file_or_folder);

// Writes sequence.json, completely or not at all, so that ReadSequence returns the same (angles to
// the last bit of a double). The referenced files are the caller's, and so is the folder. Throws
// std::runtime_error naming the file.
void WriteSequence(const Sequence& sequence, const std::filesystem::path& folder);

}  // namespace pleinair
