// The complete offline part of relighting: computed once per site, stored, and loaded later.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/blob_store.h"
#include "relight/progress.h"
#include "relight/survey/survey.h"
#include "relight/transport/transport.h"
#include "relight/volume/probe_operator.h"
#include "sunmodel/clear_sky.h"

namespace pleinair {

// What was measured on the site.
struct SiteModel {
  Mesh mesh;
  // Absent where a site has only its mesh and given albedos.
  std::optional<SurveyMap> environment;
  // Relative deviation of the materials' albedo, shared by all; where there is no environment.
  double material_albedo_stddev = 0.0;
  std::vector<std::string> diffuse_regions;  // Groups or materials; empty means all.
  std::optional<Gray8Image> diffuse_mask;    // Over the map; 255 = may be sampled.
};

struct PrepareOptions {
  int bounces = kAllBounces;
  GatherOptions gather;
  // focus_m is set by PrepareScene: to the first of focus_points_m, or where there are none to the
  // middle of the probe box, on which then all stages depend.
  PatchOptions patches;
  ProbeOptions probes;
  BoundingBox probe_box;  // Where virtual objects stand: of the probes alone.
  glm::ivec3 probe_counts{8};
  int survey_receiver_block_px = 4;  // As SurfaceViewOptions::receiver_block_px.
  // Width of the environment map used for the survey: means over its own pixels. Divides its own
  // width, by a number that divides its height; 0: its own.
  int survey_map_width = 0;
  // Memory that light between patches may take; more is refused before work begins. 0: no limit.
  std::size_t memory_limit_bytes = 0;
};

struct PreparedScene {
  PrepareOptions options;
  PatchScene patches;  // Albedos as the survey found them.
  PatchTransport transport;
  std::vector<std::uint8_t> patch_is_diffuse;  // Per patch: in a region that may be sampled.
  std::optional<Survey> survey;
  std::optional<UtcTime> survey_time;
  // How far all albedos may be off together, relative.
  glm::dvec3 albedo_stddev_rgb{0.0};
  double aerosol_optical_depth_500nm = kStandardAerosolDepth500nm;  // Haze of clear skies there.
  ProbeOperator probes;
  std::vector<std::string> notes;  // For the report: ground extended, disc clipped, ...
  bool from_store = false;         // Every stage was loaded, none computed.
};

// Computes, or loads from `store`, the stages: transport between patches; survey light and albedo
// (interreflection iterated to convergence); probe operator. Each stage is saved when done, so that
// an interrupted preparation goes on where it stopped. A damaged part is recomputed.
//
// Throws  std::invalid_argument for options or data that make no sense, naming the field; a
//         diffuse region that is neither a group nor a material of the mesh, naming it.
//         std::runtime_error where the patches would take more memory than allowed.
PreparedScene PrepareScene(const SiteModel& site,
                           const PrepareOptions& options,
                           BlobStore& store,
                           const Progress& progress);

}  // namespace pleinair
