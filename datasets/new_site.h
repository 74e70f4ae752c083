// Makes a site's folder part by part: place, mesh, camera, lens, pose, albedo, objects. Each call
// writes one part of site.json, completely or not at all, and copies the files that it names.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/utc_time.h"
#include "sunmodel/site.h"

namespace pleinair {

// Units and axes of a mesh file.
struct MeshFrame {
  double unit_m = 1.0;   // > 0.
  bool y_is_up = false;  // +X right, +Y up, +Z to the viewer; not for glTF, which is turned anyway.

  glm::dmat4 MetresZUpFromFile() const;
};
// "m", "cm", "mm", "ft", "in". Throws std::invalid_argument naming the text.
double MetresOfUnit(const std::string& unit);

enum class SitePart { kPlace, kMesh, kCamera, kLens, kPose, kAlbedo, kObjects };
inline constexpr std::array kSiteParts{SitePart::kPlace,
                                       SitePart::kMesh,
                                       SitePart::kCamera,
                                       SitePart::kLens,
                                       SitePart::kPose,
                                       SitePart::kAlbedo,
                                       SitePart::kObjects};

// One part of a site, for messages and questions.
struct SitePartState {
  SitePart part{};
  std::string name;
  std::optional<std::string> value;  // The part's state in words; none: missing.
  bool is_required = true;           // Required for every run.
  std::string how;                   // How to get it, in words.
  std::string command;               // The option that writes it.
};

// In kSiteParts' order. Throws std::runtime_error, one line, for a folder without a site's file, or
// one that is no JSON object.
std::vector<SitePartState> SitePartsIn(const std::filesystem::path& folder);

// Makes `folder` and an empty site.json in it, where there is none, nor a sequence.json. Throws
// std::runtime_error naming what is in the way.
void StartSite(const std::filesystem::path& folder);

// Writes the place. Throws std::invalid_argument as Site::Validate; std::runtime_error as
// EditSiteFile.
void SetSitePlace(const std::filesystem::path& folder, const Site& site);

// Writes the mesh as scene.obj into the folder, in metres with +Z up; the name has a number where
// there is another scene.obj. The mesh that this function has written before is removed. Returns
// the names in diffuse_regions that the mesh lacks, which are dropped there. Throws as LoadMesh;
// std::runtime_error where coordinates are then beyond what LoadMesh takes.
std::vector<std::string> SetSiteMesh(const std::filesystem::path& folder,
                                     const std::filesystem::path& mesh,
                                     const MeshFrame& frame);
// Names of its groups or materials. Throws std::runtime_error naming one that the mesh lacks.
void SetDiffuseRegions(const std::filesystem::path& folder, const std::vector<std::string>& names);

// Sets a device or a camera's identity, for live runs. Or uses a photograph: its size and EXIF
// focal length are a first lens, also in place of another photograph's; not where the site has a
// calibrated lens. Throws std::runtime_error for a picture that cannot be read.
enum class SiteLens {
  kAsAsked,   // A photograph's; for a device none is asked for.
  kReplaced,  // A photograph's, in place of another one's.
  kKept,      // The calibrated one, not the photograph's.
};
SiteLens SetSiteCamera(const std::filesystem::path& folder, const std::string& device_or_photo);
// Replaces the lens, and notes about it.
void SetSiteLens(const std::filesystem::path& folder, const CameraIntrinsics& lens);

// `stddev_rad` as Sequence::pose_stddev_rad. `folder` and `out` as for EditSiteFile. Throws
// std::invalid_argument unless it is a rotation and a translation; std::runtime_error where frames
// state their own poses, which take precedence.
void SetSitePose(const std::filesystem::path& folder,
                 const glm::dmat4& camera_from_world,
                 std::optional<double> stddev_rad,
                 const std::filesystem::path& out = {});

// Copies the map, and removes the copy that this function has made before. Throws as
// ReadRadianceImage, and std::runtime_error unless it is twice as wide as high.
void SetSiteEnvironment(const std::filesystem::path& folder,
                        const std::filesystem::path& map,
                        const glm::dvec3& position_m,
                        UtcTime time);
// States that the materials' Kd is measured, or guessed.
void SetSiteAlbedos(const std::filesystem::path& folder, bool known);

// Copies the object's files and adds it, turned about the vertical, counter-clockwise from above.
void AddSiteObject(const std::filesystem::path& folder,
                   const std::filesystem::path& mesh,
                   const MeshFrame& frame,
                   const glm::dvec3& at_m,
                   double turn_rad);

}  // namespace pleinair
