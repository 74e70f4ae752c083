// A recorded sequence's files as what relight and render work on.
#pragma once

#include <cstdint>
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

namespace pleinair {

// Of one virtual object, as its mesh file animates it.
struct ObjectMotion {
  std::size_t entry = 0;  // Into the sequence's virtual_objects.
  glm::dmat4 world_from_file{1.0};
  PartMotion of_part;

  // Takes the object from where it is at the first frame to where it is `time_s` later.
  glm::dmat4 WorldFromStart(double time_s) const;
};

// Virtual objects: a part of its own for what a mesh file animates by itself.
struct SiteObjects {
  std::vector<VirtualObject> parts;   // In world coordinates, as in the first frame.
  std::vector<ObjectMotion> motions;  // One a part.
  std::vector<std::string> notes;     // What was repaired in loading.

  void Append(SiteObjects more);
};

// The parts of one entry, whose path is relative to `folder`, or absolute. Throws
// std::runtime_error, one line with the file and what was expected.
SiteObjects LoadObject(const std::filesystem::path& folder,
                       const VirtualObjectEntry& entry,
                       std::size_t index);

struct SequenceSite {
  SiteModel model;
  std::vector<VirtualObject> objects;  // SiteObjects' parts.
  std::vector<ObjectMotion> motions;
  // Around the objects in all frames, or around what the first camera looks at.
  BoundingBox probe_box;
  // What the cameras look at: patches are finest there. Not where the objects are, so that what is
  // prepared serves other objects, too.
  std::vector<glm::dvec3> viewed_m;
  bool is_indoors = false;         // The first camera sees little of the sky.
  std::vector<std::string> notes;  // What was repaired or assumed in loading.
  // What there is to say where the materials' albedo is used: without an environment map.
  std::string materials_note;
  bool albedo_is_a_guess = false;  // The materials'.
};

// Where neither a site nor `environment.sun_direction_enu` says where the sun is: takes it from the
// environment map, for the map and for the frames that do not state their own. A map without a sun
// is overcast, and so are those frames. Returns what was done, for the report.
// Throws std::runtime_error, one line, for a frame that is said not to be overcast under such a
// map.
std::vector<std::string> FindSunInMap(Sequence& sequence);

// "azimuth 144.0 deg, elevation 52.6 deg", for people.
std::string AzimuthAndElevation(const glm::dvec3& direction_enu);

// Loads mesh, environment map, mask and objects. A sun that the map shows 3 deg or more from where
// it is stated, or computed, is a note. Where nothing says where it is, as FindSunInMap.
// Throws std::runtime_error, one line with the file and what was expected.
SequenceSite LoadSequenceSite(const Sequence& sequence);

double SecondsSinceFirstFrame(const Sequence& sequence, UtcTime time);

// Poses for FramePipeline::Process, so long after the first frame; empty where nothing moves.
std::vector<glm::dmat4> ObjectPosesAt(std::span<const ObjectMotion> motions, double time_s);

// What may be asked of the offline part; what is unset is as PrepareOptions has it.
struct PrepareSettings {
  int bounces = kAllBounces;
  std::optional<double> patch_size_m;  // Longest edge of patches near what cameras view.
  std::optional<int> rays;             // A receiver of light.
  double ground_albedo = 0.0;          // As PatchOptions has it.
  // Of the probe grid: how many along x, y, z, or how far apart; not both.
  std::optional<glm::ivec3> probe_counts;
  std::optional<double> probe_spacing_m;
  std::optional<int> probe_rays;
  std::optional<int> map_width;  // Of the environment map, in pixels; its own unless said.
  std::uint64_t seed = 1;        // Of all rays.

  bool operator==(const PrepareSettings&) const = default;
};

// The options that `prepare` and `run` share, so that one finds what the other has stored.
// Throws std::invalid_argument for a spacing that is not positive, or needs more than 64 probes
// along an axis.
PrepareOptions PrepareOptionsFor(const SequenceSite& site, const PrepareSettings& settings = {});

}  // namespace pleinair
