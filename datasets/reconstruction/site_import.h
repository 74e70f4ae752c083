// A site and a sequence from a reconstruction and its photographs.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/vec2.hpp>

#include "calib/reconstruction/geo_alignment.h"
#include "calib/reconstruction/surfaces.h"
#include "calib/reconstruction/up_direction.h"
#include "scene/utc_time.h"
#include "sunmodel/site.h"

namespace pleinair {

// Two points of the reconstruction by their ids.
struct PointPair {
  std::int64_t first = 0;
  std::int64_t second = 0;
};

// Two places in a picture, at points of the reconstruction.
struct PickPair {
  std::string picture;
  glm::dvec2 first_px{0.0};
  glm::dvec2 second_px{0.0};
};

// A length in metres between two points.
struct KnownLength {
  double length_m = 0.0;
  std::variant<PointPair, PickPair> between;
};

// A person's statement of a picture's azimuth.
struct StatedHeading {
  std::string picture;
  double azimuth_rad = 0.0;  // Azimuth of the view, clockwise from true north.
  double sigma_rad = 0.0;    // Above 0.
};

// A mark on a photograph, in its pixels.
struct PictureMark {
  std::string picture;
  glm::dvec2 pixel{0.0};
  std::string surface;
};

// Input and choices of an import.
struct SiteImportOptions {
  std::filesystem::path reconstruction;  // As for ReadReconstruction.
  std::filesystem::path photos;          // Folder that the pictures' names are relative to.
  std::filesystem::path out;             // Is created; must be absent or empty.
  std::optional<KnownLength> length;     // None: from GPS positions.
  std::optional<Site> site;              // None: from GPS.
  std::vector<StatedHeading> headings;   // In addition to the photographs' compasses.
  // Offset of the cameras' clocks from UTC, where the photographs do not state it.
  std::optional<std::chrono::minutes> utc_offset;
  std::map<std::string, UtcTime> times;  // For each picture; replaces the photographs' times.
  std::vector<PictureMark> marks;
  std::string camera;  // The camera whose pictures become frames; empty: the one with the most.
  double tolerance_m = 0.0;    // SurfaceOptions::tolerance_m; 0: half a percent of the distance.
  int longest_side_px = 1600;  // Photographs are reduced to it; 0: not reduced.
  SurfaceOptions surfaces;     // All but tolerance_m.
};

// What was imported and how well it is placed.
struct SiteImportReport {
  std::size_t pictures = 0;
  std::size_t points = 0;
  std::size_t frames = 0;
  UpEstimate up;
  GeoAlignment earth;
  double metres_per_unit = 1.0;
  Site site;
  double tolerance_m = 0.0;
  std::vector<SiteSurface> surfaces;
  std::vector<std::string> notes;
};

// Reads the reconstruction, aligns it, fits ground and walls, and writes `out`: sequence.json with
// a frame for each photograph of one camera, the mesh and the photographs. The folder is a site,
// too.
//
// World   metres, +X east, +Y north, +Z up; the origin is on the ground below the cameras' mean.
// Throws  std::runtime_error or std::invalid_argument, one line: what, where, what was expected.
//         `out` is then unchanged.
SiteImportReport ImportSite(const SiteImportOptions& options);

}  // namespace pleinair
