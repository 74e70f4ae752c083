#include "relight/prepared_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include "relight/internal/content_hash.h"
#include "relight/internal/serialization.h"
#include "relight/internal/stored_stages.h"
#include "scene/lat_long.h"

namespace pleinair {
namespace {

using internal::ContentHash;

// Part of every key: to be raised when what a stage makes, or its form, changes.
constexpr std::string_view kFormat = "pleinair-prepared-18";

std::string PatchKey(const SiteModel& site, const PrepareOptions& options) {
  ContentHash hash;
  hash.Add(kFormat).Add("patches");
  hash.AddAll(site.mesh.positions_m).AddAll(site.mesh.triangles);
  hash.AddAll(site.mesh.triangle_material).AddAll(site.mesh.triangle_group);
  for (const Material& material : site.mesh.materials) {
    hash.Add(material.name).AddVector(material.diffuse_albedo);
  }
  for (const std::string& name : site.mesh.group_names) hash.Add(name);
  const PatchOptions& patches = options.patches;
  hash.AddVector(patches.focus_m).AddAll(patches.focus_points_m);
  hash.Add(patches.patch_size_m).Add(patches.growth_per_m);
  hash.Add(patches.extend_ground).Add(patches.ground_albedo).Add(patches.join_small);
  hash.Add(options.gather.rays_per_receiver).Add(options.gather.seed);
  hash.Add(options.gather.from_exposed_parts);
  return hash.Hex();
}

std::string SurveyKey(const std::string& patch_key,
                      const SiteModel& site,
                      const PrepareOptions& options) {
  ContentHash hash;
  hash.Add(kFormat).Add("survey").Add(patch_key).Add(options.bounces);
  hash.Add(options.survey_receiver_block_px).Add(options.survey_map_width);
  const SurveyMap& map = *site.environment;
  hash.AddImage(map.radiance).AddVector(map.position_m).AddVector(map.sun_direction_enu);
  hash.Add(map.sun_angular_radius_rad).AddVector(map.clear_sky_beam_to_diffuse_rgb);
  hash.Add(map.misplacement.turned_rad).Add(map.misplacement.moved_m);
  for (const std::string& name : site.diffuse_regions) hash.Add(name);
  if (site.diffuse_mask) hash.AddImage(*site.diffuse_mask);
  return hash.Hex();
}

std::string ProbeKey(const std::string& scene_key, const PrepareOptions& options) {
  ContentHash hash;
  hash.Add(kFormat).Add("probes").Add(scene_key);
  hash.AddVector(options.probe_box.lower_m).AddVector(options.probe_box.upper_m);
  hash.AddVector(options.probe_counts);
  hash.Add(options.probes.rays_per_probe).Add(options.probes.seed);
  return hash.Hex();
}

// Per patch: whether its group or its material is among the named; none named means all.
std::vector<std::uint8_t> DiffusePatches(const PatchScene& scene,
                                         const std::vector<std::string>& names) {
  const Mesh& mesh = scene.mesh;
  if (names.empty()) return std::vector<std::uint8_t>(scene.PatchCount(), 1);
  std::vector<std::uint8_t> group_named(mesh.group_names.size(), 0);
  std::vector<std::uint8_t> material_named(mesh.materials.size(), 0);
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t i = 0; i < mesh.group_names.size(); ++i) {
      if (mesh.group_names[i] != name) continue;
      group_named[i] = 1;
      found = true;
    }
    for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
      if (mesh.materials[i].name != name) continue;
      material_named[i] = 1;
      found = true;
    }
    if (!found) {
      throw std::invalid_argument("diffuse_regions: \"" + name +
                                  "\" is neither a group nor a material of the scene's mesh");
    }
  }
  std::vector<std::uint8_t> diffuse(scene.PatchCount());
  for (std::size_t i = 0; i < diffuse.size(); ++i) {
    diffuse[i] = group_named[scene.GroupOf(i)] | material_named[scene.MaterialOf(i)];
  }
  return diffuse;
}

// Checks that the stages would make only when they run, and not where they are loaded.
void Check(const SiteModel& site, const PrepareOptions& options) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument(what); };
  if (options.bounces < kAllBounces) {
    refuse("bounces is " + std::to_string(options.bounces) + ": expected a count, or -1 for all");
  }
  options.gather.Validate();
  options.probes.Validate();
  if (options.survey_receiver_block_px < 1) {
    refuse("survey_receiver_block_px is " + std::to_string(options.survey_receiver_block_px) +
           ": expected at least 1");
  }
  MakeProbeGrid(options.probe_box, options.probe_counts).Validate();
  if (!(site.material_albedo_stddev >= 0.0) || !std::isfinite(site.material_albedo_stddev)) {
    refuse("material_albedo_stddev is " + std::to_string(site.material_albedo_stddev) +
           ": expected 0 or more");
  }
  if (!site.environment) return;
  site.environment->Validate();
  const RgbImage& map = site.environment->radiance;
  const int width = options.survey_map_width;
  if (width < 0 ||
      (width > 0 && (map.width % width != 0 || map.height % (map.width / width) != 0))) {
    refuse("survey_map_width (setting prepare.map_width) is " + std::to_string(width) +
           ": expected the environment map's " + std::to_string(map.width) +
           " over a number that divides it and the map's height, " + std::to_string(map.height));
  }
  if (!site.diffuse_mask) return;
  if (site.diffuse_mask->width != map.width || site.diffuse_mask->height != map.height) {
    refuse("diffuse_mask has " + std::to_string(site.diffuse_mask->width) + "x" +
           std::to_string(site.diffuse_mask->height) + " pixels: expected the environment map's " +
           std::to_string(map.width) + "x" + std::to_string(map.height));
  }
}

// What the site is surveyed by.
struct MapAndMask {
  SurveyMap map;
  std::optional<Gray8Image> mask;
};

// A pixel of the reduced mask may be sampled where all pixels that it covers may.
MapAndMask Downsampled(const SiteModel& site, int width) {
  MapAndMask small{*site.environment, std::nullopt};
  const int factor = small.map.radiance.width / width;
  const LatLongSize size{width, small.map.radiance.height / factor};
  small.map.radiance = DownsampleLatLong(small.map.radiance, size);
  if (!site.diffuse_mask) return small;
  small.mask.emplace(size.width, size.height);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      std::uint8_t least = 255;
      for (int i = 0; i < factor * factor; ++i) {
        least = std::min(least,
                         site.diffuse_mask->At(x * factor + i % factor, y * factor + i / factor));
      }
      small.mask->At(x, y) = least;
    }
  }
  return small;
}

constexpr double kMiB = 1024.0 * 1024.0;

// Sun and sky, one after the other; the sky's rays are the patches' own.
std::size_t TransportBytes(const PreparedScene& prepared) {
  return RadiosityBytes(prepared.patches.PatchCount(), 1, prepared.options.gather, 0);
}

std::string MiBText(std::size_t bytes) {
  return std::to_string(std::llround(static_cast<double>(bytes) / kMiB)) + " MiB";
}

std::string LightBetweenPatches(const PreparedScene& prepared) {
  return "light between " + std::to_string(prepared.patches.PatchCount()) + " patches, at most " +
         MiBText(TransportBytes(prepared));
}

void RequireMemoryFor(const PreparedScene& prepared) {
  const std::size_t limit = prepared.options.memory_limit_bytes;
  if (limit == 0 || TransportBytes(prepared) <= limit) return;
  throw std::runtime_error(LightBetweenPatches(prepared) + ", but " + MiBText(limit) +
                           " are there: expected a larger patch_size_m or fewer "
                           "rays_per_receiver (settings prepare.patch_size_m, prepare.rays)");
}

}  // namespace

PreparedScene PrepareScene(const SiteModel& site,
                           const PrepareOptions& options,
                           BlobStore& store,
                           const Progress& progress) {
  Check(site, options);
  PreparedScene prepared;
  prepared.options = options;
  const std::vector<glm::dvec3>& focus_points_m = options.patches.focus_points_m;
  prepared.options.patches.focus_m =
      focus_points_m.empty()
          ? 0.5 * (glm::dvec3(options.probe_box.lower_m) + glm::dvec3(options.probe_box.upper_m))
          : focus_points_m.front();
  prepared.patches = BuildPatchScene(site.mesh, prepared.options.patches);
  prepared.patch_is_diffuse = DiffusePatches(prepared.patches, site.diffuse_regions);
  if (prepared.patches.ground_extended) {
    prepared.notes.emplace_back(
        "the ground ends near: it is continued to the horizon with its mean albedo");
  }
  if (prepared.patches.ground_laid) {
    prepared.notes.push_back("a ground of albedo " + std::to_string(options.patches.ground_albedo) +
                             " is laid at the mesh's foot, out to the horizon");
  }

  internal::StoredStages stages(store, progress);
  const std::string patch_key = PatchKey(site, prepared.options);
  stages.Run(
      LightBetweenPatches(prepared),
      patch_key,
      [&] {
        RequireMemoryFor(prepared);
        prepared.transport = PatchTransport(prepared.patches, options.gather);
      },
      [&](auto& archive) { archive(prepared.transport); });

  prepared.albedo_stddev_rgb = glm::dvec3(site.material_albedo_stddev);
  std::string scene_key = patch_key;
  if (site.environment) {
    scene_key = SurveyKey(patch_key, site, prepared.options);
    SurveyOptions survey_options;
    survey_options.gather = options.gather;
    survey_options.bounces = options.bounces;
    survey_options.receiver_block_px = options.survey_receiver_block_px;
    Survey survey;
    stages.Run(
        "survey: light and albedo",
        scene_key,
        [&] {
          const int own_width = site.environment->radiance.width;
          const int width = options.survey_map_width > 0 ? options.survey_map_width : own_width;
          std::optional<MapAndMask> small;
          if (width != own_width) small = Downsampled(site, width);
          const std::optional<Gray8Image>& mask = small ? small->mask : site.diffuse_mask;
          survey = MakeSurvey(small ? small->map : *site.environment,
                              prepared.transport,
                              {prepared.patch_is_diffuse, mask ? &*mask : nullptr},
                              survey_options,
                              prepared.patches);
        },
        [&](auto& archive) {
          internal::ArchiveSurvey(archive, survey);
          internal::ArchiveBlock(archive, prepared.patches.face_albedo_rgb);
        });
    prepared.patches.skyline = survey.skyline;
    prepared.notes.insert(
        prepared.notes.end(), survey.light.notes.begin(), survey.light.notes.end());
    prepared.albedo_stddev_rgb = survey.light.albedo_stddev_rgb;
    prepared.aerosol_optical_depth_500nm =
        survey.light.aerosol_optical_depth_500nm.value_or(kStandardAerosolDepth500nm);
    prepared.survey_time = site.environment->time;
    prepared.survey = std::move(survey);
  }

  stages.Run(
      "probes",
      ProbeKey(scene_key, prepared.options),
      [&] {
        prepared.probes = ProbeOperator(prepared.patches,
                                        prepared.survey ? &*prepared.survey : nullptr,
                                        MakeProbeGrid(options.probe_box, options.probe_counts),
                                        options.probes);
      },
      [&](auto& archive) { archive(prepared.probes); });
  prepared.from_store = stages.AllLoaded();
  return prepared;
}

}  // namespace pleinair
