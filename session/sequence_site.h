// Loads a recorded sequence's files as input of relight and render.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "datasets/sequence.h"
#include "relight/prepared_scene.h"
#include "render/compositor.h"
#include "scene/part_motion.h"
#include "session/check/site_warning.h"

namespace pleinair {

// The motion of one virtual object, by the animation of its mesh file.
struct ObjectMotion {
  std::size_t entry = 0;  // Into the sequence's virtual_objects.
  glm::dmat4 world_from_file{1.0};
  PartMotion of_part;

  // The transform from the object's place at the first frame to that `time_s` later.
  glm::dmat4 WorldFromStart(double time_s) const;
};

// Virtual objects: each separately animated part of a mesh file is a part of its own.
struct SiteObjects {
  std::vector<VirtualObject> parts;   // In world coordinates, as in the first frame.
  std::vector<ObjectMotion> motions;  // One for each part.
  std::vector<std::string> notes;     // Notes on repairs in loading.

  void Append(SiteObjects more);
};

// The parts of one entry, whose path is relative to `folder`, or absolute. Throws
// std::runtime_error, one line with the file and what was expected.
SiteObjects LoadObject(const std::filesystem::path& folder,
                       const VirtualObjectEntry& entry,
                       std::size_t index);

// A site ready for preparation. World frame: metres, east-north-up.
struct SequenceSite {
  SiteModel model;
  std::vector<VirtualObject> objects;  // SiteObjects' parts.
  std::vector<ObjectMotion> motions;
  // Box around the objects in all frames, or around what the first camera views.
  BoundingBox probe_box;
  // Places that the cameras view: patches are finest there. They do not depend on the objects, so
  // that the prepared parts serve other objects, too.
  std::vector<glm::dvec3> viewed_m;
  bool is_indoors = false;         // The first camera sees little of the sky.
  std::vector<std::string> notes;  // Notes on repairs and assumptions in loading.
  SiteWarnings warnings;           // What needs no picture to be seen: see LoadSequenceSite.
  // Notes for the case that the materials' albedo is used: without an environment map.
  std::string materials_note;
  bool albedo_is_a_guess = false;  // The materials'.

  // Whether mesh or camera seem to be in another unit or turned: then nothing is where it is looked
  // for.
  bool IsMisread() const { return std::ranges::any_of(warnings, &SiteWarning::spoils_forecast); }
};

// Loads mesh, environment map, mask and objects, and checks what needs no pictures (`warnings`):
// units, a pose that another reading makes look at the mesh, openings, the frames' order. A sun in
// the map that is 3 deg or more from its stated or computed direction is a note. Without such a
// direction as FindSunInMap (survey_map_file.h). Throws std::runtime_error, one line with the file
// and what was expected.
SequenceSite LoadSequenceSite(const Sequence& sequence);

// Seconds from the sequence's first frame to `time`; the clock of animations.
double SecondsSinceFirstFrame(const Sequence& sequence, UtcTime time);

// Returns poses for FramePipeline::Process, a time after the first frame; empty where nothing
// moves.
std::vector<glm::dmat4> ObjectPosesAt(std::span<const ObjectMotion> motions, double time_s);

// Options of the offline part; unset ones are as in PrepareOptions.
struct PrepareSettings {
  int bounces = kAllBounces;
  std::optional<double> patch_size_m;  // Longest edge of patches near what cameras view.
  std::optional<int> rays;             // For each receiver of light.
  double ground_albedo = 0.0;          // As in PatchOptions.
  // The probe grid: numbers along x, y, z, or spacing; not both.
  std::optional<glm::ivec3> probe_counts;
  std::optional<double> probe_spacing_m;
  std::optional<int> probe_rays;
  std::optional<int> map_width;  // Width of the environment map, in pixels; unset: its own.
  std::uint64_t seed = 1;        // Seed of all rays.

  bool operator==(const PrepareSettings&) const = default;
};

// Returns the options that `prepare` and `run` share, so that one finds the parts that the other
// has stored.
// Throws std::invalid_argument for a spacing that is not positive, or needs more than 64 probes
// along an axis.
PrepareOptions PrepareOptionsFor(const SequenceSite& site, const PrepareSettings& settings = {});

}  // namespace pleinair
