#include "apps/irradiance_command.h"

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/irradiance_file.h"
#include "apps/number_pair.h"
#include "apps/progress.h"
#include "apps/shared_ranks.h"
#include "pipeline/frame_view.h"
#include "pipeline/sun_state.h"
#include "relight/surface_view_builder.h"
#include "scene/mesh_io.h"
#include "scene/whole_file.h"
#include "session/available_memory.h"
#include "session/file_blob_store.h"
#include "session/sequence_session.h"
#include "session/sequence_site.h"
#include "session/session_choices.h"
#include "session/survey_map_file.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr double kMiB = 1024.0 * 1024.0;

SkyRegions RegionsOf(const IrradianceCommandOptions& options) {
  if (options.uniform_sky || !options.sequence.empty()) return SkyRegions(1, 1);
  if (options.sky_regions.empty()) return SkyRegions();
  const auto [bands, sectors] = ParsePair<int>(options.sky_regions, 'x', "--sky-regions");
  return SkyRegions(bands, sectors);
}

struct SunAngles {
  double azimuth_deg;
  double elevation_deg;

  glm::dvec3 DirectionEnu() const {
    const double azimuth = RadFromDeg(azimuth_deg);
    const double elevation = RadFromDeg(elevation_deg);
    return {std::cos(elevation) * std::sin(azimuth),
            std::cos(elevation) * std::cos(azimuth),
            std::sin(elevation)};
  }
};

SunAngles ParseSun(const std::string& text) {
  const auto [azimuth_deg, elevation_deg] = ParsePair<double>(text, ',', "--sun");
  if (!(std::abs(azimuth_deg) <= 360.0) || !(std::abs(elevation_deg) <= 90.0)) {
    throw std::invalid_argument(fmt::format(
        "--sun '{}': expected an azimuth of -360..360 and an elevation of -90..90 degrees", text));
  }
  return {azimuth_deg, elevation_deg};
}

// The light whose irradiance is computed. A missing part is dark.
struct PointsLight {
  Lighting lighting;
  std::vector<std::shared_ptr<const SkyShape>> sky_shapes;  // Of lighting.sky.

  glm::vec3 SkyRadiance(const glm::vec3& direction_enu) const {
    glm::vec3 radiance(0.0f);
    for (std::size_t k = 0; k < sky_shapes.size(); ++k) {
      radiance +=
          glm::vec3(lighting.sky[k].irradiance_rgb) * sky_shapes[k]->Radiance(direction_enu);
    }
    return radiance;
  }
};

// The site's mesh with the albedos that its survey found: a material of its own for each patch.
Mesh MeshAsSurveyed(const PreparedScene& scene) {
  const Mesh& patches = scene.patches.mesh;
  Mesh mesh = patches;
  mesh.materials.clear();
  mesh.triangles.clear();
  mesh.triangle_group.clear();
  mesh.triangle_material.clear();
  for (std::size_t patch = 0; patch < scene.patches.PatchCount(); ++patch) {
    Material material = patches.materials[scene.patches.MaterialOf(patch)];
    material.diffuse_albedo = scene.patches.face_albedo_rgb[2 * patch];
    mesh.materials.push_back(material);
  }
  for (std::size_t i = 0; i < patches.triangles.size(); ++i) {
    if (scene.patches.source_triangle[i] == PatchScene::kExtension) continue;
    const auto face = scene.patches.FaceOfSide(static_cast<std::int32_t>(2 * i));
    mesh.triangles.push_back(patches.triangles[i]);
    mesh.triangle_group.push_back(patches.triangle_group[i]);
    mesh.triangle_material.push_back(static_cast<std::uint32_t>(face / 2));
  }
  return mesh;
}

struct EstimatedFrame {
  Mesh mesh;
  PointsLight light;
};

// The light of frame `index` by itself: nothing is carried over from frames before it.
EstimatedFrame EstimateFrame(const IrradianceCommandOptions& options) {
  Sequence sequence = ReadSequence(options.sequence);
  const auto index = static_cast<std::size_t>(options.frame);
  if (options.frame < 0 || index >= sequence.frames.size()) {
    throw std::invalid_argument(fmt::format("--frame {}: {} has frames 0 to {}",
                                            options.frame,
                                            (options.sequence / "sequence.json").string(),
                                            sequence.frames.size() - 1));
  }
  SessionOptions run;
  run.light.seed = options.gather.seed;
  FindSunInMap(sequence);
  const SequenceSite site = LoadSequenceSite(sequence);
  for (const std::string& note : site.notes) spdlog::warn("{}", note);
  if (!site.materials_note.empty()) spdlog::warn("{}", site.materials_note);
  FileBlobStore store(options.cache);
  PrepareSettings prepare;
  prepare.ground_albedo = options.gather.ground_albedo;
  const PreparedScene scene =
      PrepareScene(site.model, PrepareOptionsFor(site, prepare), store, ProgressOnStandardError());

  const std::unique_ptr<LightingSource> source =
      MakeSourceFor(run, sequence, scene.aerosol_optical_depth_500nm);
  sequence.frames = {sequence.frames[index]};
  const auto frame = MakeRecordedFrameSource(sequence, FrameKind::kLinear)->Next();
  const auto failed = [&](const std::string& reason) {
    return std::runtime_error(
        fmt::format("{}: frame {}: {}", options.sequence.string(), options.frame, reason));
  };
  if (!frame) throw failed("is not there");
  if (!*frame) throw failed((*frame).error().reason);

  const SunState sun = SunOfFrame(sequence.site, **frame);
  const ScaledClearSky clear_sky(sequence.site, scene.survey ? &scene.survey->light : nullptr);
  const auto basis = source->BasisFor(**frame, sun);
  if (!basis) throw failed(basis.error().reason);
  EstimatedFrame estimated;
  SurfaceViewBuilder views(scene, {});
  const SurfaceView& view = views.Update((*frame)->camera,
                                         sun.direction_enu,
                                         sun.angular_radius_rad,
                                         *basis,
                                         SampleRegionsOf(**frame));
  const auto shapes = views.SkyShapes();
  estimated.light.sky_shapes.assign(shapes.begin(), shapes.end());
  auto estimate = source->Estimate({**frame, view, sun, clear_sky.At(sun.direction_enu)});
  if (!estimate) throw failed(estimate.error().reason);
  estimated.light.lighting = std::move(estimate->lighting);
  estimated.mesh = scene.survey ? MeshAsSurveyed(scene) : site.model.mesh;
  return estimated;
}

std::vector<glm::vec3> IrradianceUnder(const PointsLight& light,
                                       LightPart part,
                                       PointIrradiance& points) {
  std::vector<glm::vec3> irradiance =
      points.OfSky([&](const glm::vec3& direction) { return light.SkyRadiance(direction); }, part);
  const DirectionalLight& sun = light.lighting.sun;
  if (sun.irradiance_rgb == glm::dvec3(0.0)) return irradiance;
  const std::vector<glm::vec3> of_sun =
      points.OfSun(sun.direction_enu, sun.angular_radius_rad, part);
  for (std::size_t i = 0; i < irradiance.size(); ++i) {
    irradiance[i] += glm::vec3(sun.irradiance_rgb) * of_sun[i];
  }
  return irradiance;
}

std::vector<ShRgb> CoefficientsUnder(const PointsLight& light,
                                     LightPart part,
                                     PointIrradiance& points) {
  std::vector<ShRgb> coefficients = points.ShOfSky(
      [&](const glm::vec3& direction) { return light.SkyRadiance(direction); }, part);
  const DirectionalLight& sun = light.lighting.sun;
  if (sun.irradiance_rgb == glm::dvec3(0.0)) return coefficients;
  const std::vector<ShRgb> of_sun = points.ShOfSun(sun.direction_enu, sun.angular_radius_rad, part);
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    for (std::size_t k = 0; k < of_sun[i].size(); ++k) {
      coefficients[i][k] += glm::vec3(sun.irradiance_rgb) * of_sun[i][k];
    }
  }
  return coefficients;
}

std::string DescribeRegions(const SkyRegions& regions, bool uniform) {
  if (uniform) return R"({"sky": "uniform", "of": "unit radiance of the entire sky"})";
  return fmt::format(
      R"({{"sky_regions": {{"bands": {}, "sectors": {}}}, "of": "unit radiance of each region; )"
      R"(bands equal in sin(elevation), band 0 at the horizon, sector 0 from north clockwise, )"
      R"(region = sectors * band + sector"}})",
      regions.Bands(),
      regions.Sectors());
}

std::string DescribeSun(const SunAngles& sun) {
  return fmt::format(R"({{"sun": {{"azimuth_deg": {}, "elevation_deg": {}, "angular_radius_deg": )"
                     R"({:.4f}}}, "of": "unit irradiance normal to the beam"}})",
                     sun.azimuth_deg,
                     sun.elevation_deg,
                     DegFromRad(kMeanSunAngularRadiusRad));
}

std::string DescribeFrame(int frame, const Lighting& lighting) {
  const auto vector = [](const glm::dvec3& v) {
    return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
  };
  return fmt::format(
      R"({{"frame": {}, "of": "the frame's estimated light, in the units of its pictures", )"
      R"("sun_direction_enu": {}, "sun_irradiance_rgb": {}, "sky_irradiance_rgb": {}}})",
      frame,
      vector(lighting.sun.direction_enu),
      vector(lighting.sun.irradiance_rgb),
      vector(lighting.SkyIrradianceRgb()));
}

void CheckOptions(const IrradianceCommandOptions& options) {
  const int lights = (options.sky_regions.empty() ? 0 : 1) + (options.uniform_sky ? 1 : 0) +
                     (options.sun.empty() ? 0 : 1);
  if (options.scene.empty() == options.sequence.empty()) {
    throw std::invalid_argument("expected either --scene or --sequence");
  }
  if (lights > 1) {
    throw std::invalid_argument("expected one of --sky-regions, --sky and --sun");
  }
  if (lights > 0 && !options.sequence.empty()) {
    throw std::invalid_argument(
        "--sequence brings its own light: expected none of --sky-regions, --sky and --sun");
  }
}

}  // namespace

void RunIrradianceCommand(const IrradianceCommandOptions& options) {
  RequireReplaceable(options.out);
  CheckOptions(options);
  PointIrradianceOptions gather = options.gather;
  gather.ranks = SharedRanks();
  gather.regions = RegionsOf(options);
  const bool coefficients = options.spherical_harmonics;
  const PointsFile asked = ReadPointsFile(options.points, !coefficients);

  PointsLight light;
  Mesh mesh;
  IrradianceHeading heading;
  heading.part = options.light;
  heading.bounces = gather.bounces;
  std::optional<SunAngles> sun;
  if (!options.sequence.empty()) {
    EstimatedFrame estimated = EstimateFrame(options);
    mesh = std::move(estimated.mesh);
    light = std::move(estimated.light);
    heading.light_json = DescribeFrame(options.frame, light.lighting);
  } else {
    if (!options.sun.empty()) sun = ParseSun(options.sun);
    heading.light_json =
        sun ? DescribeSun(*sun) : DescribeRegions(gather.regions, options.uniform_sky);
    LoadedMesh loaded = LoadMesh(options.scene);
    for (const std::string& note : loaded.report.notes) spdlog::warn("{}", note);
    mesh = std::move(loaded.mesh);
  }

  FileBlobStore store(options.cache);
  PointIrradiance points(
      mesh, {asked.points_m, asked.normals}, gather, ProgressOnStandardError(), &store);
  if (options.light != LightPart::kDirect && gather.bounces != 0) {
    spdlog::info("{} patches, {} lights, at most {:.0f} MiB for the radiosity",
                 points.Summary().patches,
                 sun ? 1 : gather.regions.Count(),
                 static_cast<double>(points.Summary().memory_bytes) / kMiB);
    RequireMemory(points.Summary().memory_bytes,
                  "the radiosity",
                  "expected fewer --sky-regions, a larger --patch-size or fewer --patch-rays");
  }
  const std::size_t lights = gather.regions.Count();
  std::string text;
  if (coefficients) {
    std::vector<ShRgb> values;
    if (!options.sequence.empty()) {
      values = CoefficientsUnder(light, options.light, points);
    } else if (sun) {
      values = points.ShOfSun(sun->DirectionEnu(), kMeanSunAngularRadiusRad, options.light);
    } else {
      values = points.ShOfRegions(options.light);
    }
    heading.radiosity = points.Summary();
    text = CoefficientsText(heading, asked, values, sun ? 1 : lights);
  } else {
    std::vector<glm::vec3> values;
    if (!options.sequence.empty()) {
      values = IrradianceUnder(light, options.light, points);
    } else if (sun) {
      values = points.OfSun(sun->DirectionEnu(), kMeanSunAngularRadiusRad, options.light);
    } else {
      values = points.OfRegions(options.light);
    }
    heading.radiosity = points.Summary();
    text = IrradianceText(heading, asked, values, sun ? 1 : lights);
  }
  if (gather.ranks == nullptr || gather.ranks->Rank() == 0) WriteWholeText(options.out, text);
}

}  // namespace pleinair
