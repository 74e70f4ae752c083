#include "apps/tradeoff_axes.h"

#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace pleinair {
namespace {

using Judge = SweepAxis::Judge;
using Options = SessionOptions;

// Values that are numbers, each put where `set` says.
template <typename Number, typename Set>
std::vector<SweepValue> Numbers(std::initializer_list<Number> numbers, const Set& set) {
  std::vector<SweepValue> values;
  for (const Number number : numbers) {
    std::string text = std::to_string(number);
    if constexpr (std::is_floating_point_v<Number>) {
      text.erase(text.find_last_not_of('0') + 1);
      if (text.back() == '.') text.pop_back();
    }
    values.push_back({text, [set, number](Options& options) { set(options, number); }});
  }
  return values;
}

SweepValue Shapes(std::string text, std::vector<SkyShapeKind> kinds) {
  return {std::move(text), [kinds = std::move(kinds)](Options& o) { o.light.sky_shapes = kinds; }};
}

void AddFitAxes(std::vector<SweepAxis>& axes) {
  using Loss = LightingFitOptions::Loss;
  using Solver = LightingFitOptions::Solver;
  axes.push_back({"samples",
                  "Pixels to measure from (light.samples)",
                  Judge::kEstimate,
                  false,
                  Numbers<int>({25, 50, 100, 200, 500, 1000, 2000, 4000, 8000},
                               [](Options& o, int samples) { o.light.samples = samples; }),
                  "500"});
  axes.push_back(
      {"choice",
       "How they are chosen (light.choice)",
       Judge::kEstimate,
       false,
       {{"balanced", [](Options& o) { o.light.choice = SampleChoice::kBalanced; }},
        {"proportional", [](Options& o) { o.light.choice = SampleChoice::kProportional; }},
        {"random", [](Options& o) { o.light.choice = SampleChoice::kRandom; }}},
       "balanced"});
  axes.push_back({"loss",
                  "What a sample far from the model counts (light.fit.loss)",
                  Judge::kEstimate,
                  false,
                  {{"tukey", [](Options& o) { o.light.fit.loss = Loss::kTukey; }},
                   {"huber", [](Options& o) { o.light.fit.loss = Loss::kHuber; }},
                   {"squares", [](Options& o) { o.light.fit.loss = Loss::kSquares; }}},
                  "tukey"});
  axes.push_back({"solver",
                  "Of the fit (light.fit.solver)",
                  Judge::kEstimate,
                  false,
                  {{"ceres", [](Options& o) { o.light.fit.solver = Solver::kCeres; }},
                   {"closed", [](Options& o) { o.light.fit.solver = Solver::kClosed; }}},
                  "ceres"});
}

void AddModelAxes(std::vector<SweepAxis>& axes) {
  using Kind = SkyShapeKind;
  axes.push_back({"sky-shapes",
                  "What the sky is a mix of (light.sky_shapes)",
                  Judge::kTransport,
                  false,
                  {Shapes("uniform", {Kind::kUniform}),
                   Shapes("overcast", {Kind::kOvercast}),
                   Shapes("clear", {Kind::kClear}),
                   Shapes("uniform+overcast", {Kind::kUniform, Kind::kOvercast}),
                   Shapes("uniform+clear", {Kind::kUniform, Kind::kClear}),
                   Shapes("overcast+clear", {Kind::kOvercast, Kind::kClear}),
                   Shapes("all three", {Kind::kUniform, Kind::kOvercast, Kind::kClear})},
                  "all three"});
  axes.push_back({"bounces",
                  "Reflections between surfaces (prepare.bounces)",
                  Judge::kTransport,
                  false,
                  {{"0", [](Options& o) { o.prepare.bounces = 0; }},
                   {"1", [](Options& o) { o.prepare.bounces = 1; }},
                   {"2", [](Options& o) { o.prepare.bounces = 2; }},
                   {"all", [](Options& o) { o.prepare.bounces = kAllBounces; }}},
                  "all"});
}

void AddOfflineAxes(const SweepCase& sweep_case, std::vector<SweepAxis>& axes) {
  const Judge judge = sweep_case.light_is_fitted ? Judge::kTransport : Judge::kPicture;
  axes.push_back({"rays",
                  "Rays that each receiver of light casts (prepare.rays)",
                  judge,
                  true,
                  Numbers<int>({16, 64, 256, 512}, [](Options& o, int n) { o.prepare.rays = n; }),
                  "256"});
  const auto set_patches = [](Options& o, double m) { o.prepare.patch_size_m = m; };
  axes.push_back(
      {"patch-size",
       "Longest edge of patches near what the cameras look at, in metres (prepare.patch_size_m)",
       judge,
       true,
       sweep_case.is_indoors ? Numbers<double>({2.0, 1.0, 0.5, 0.25, 0.125}, set_patches)
                             : Numbers<double>({4.0, 2.0, 1.0, 0.5}, set_patches),
       sweep_case.is_indoors ? "0.25" : "0.5"});
}

void AddPictureAxes(const SweepCase& sweep_case, std::vector<SweepAxis>& axes) {
  const auto volume = [](Options& o) { o.pipeline.object_light.route = ObjectLight::kVolume; };
  const auto single_probe = [](Options& o) {
    o.pipeline.object_light.route = ObjectLight::kSingleProbe;
  };
  axes.push_back(
      {"object-light",
       "Where objects get their light from (pipeline.object_light.route)",
       Judge::kPicture,
       false,
       {{"gather", [](Options& o) { o.pipeline.object_light.route = ObjectLight::kGather; }},
        {"probe", single_probe},
        {"volume", volume},
        {"map", [](Options& o) { o.pipeline.object_light.route = ObjectLight::kVolumeByMap; }}},
       "gather"});
  axes.push_back({"object-rays",
                  "Rays at an object's vertices (pipeline.object_light.gather.rays_per_receiver)",
                  Judge::kPicture,
                  false,
                  Numbers<int>({16, 64, 256, 1024},
                               [](Options& o, int n) {
                                 o.pipeline.object_light.gather.rays_per_receiver = n;
                               }),
                  "256"});
  axes.push_back(
      {"sh-bands",
       "Bands of the light at a single probe (pipeline.object_light.single_probe.sh_bands), with "
       "pipeline.object_light.route probe",
       Judge::kPicture,
       false,
       Numbers<int>({1, 2, 3, 5, 7, 10},
                    [single_probe](Options& o, int bands) {
                      single_probe(o);
                      o.pipeline.object_light.single_probe.sh_bands = bands;
                    }),
       std::to_string(SingleProbeOptions{}.sh_bands)});
  SweepAxis probes{"probes",
                   "Probe grid (prepare.probe_counts), with pipeline.object_light.route volume",
                   Judge::kPicture,
                   false,
                   {},
                   "8x8x8"};
  for (const int side : {1, 2, 4, 8, 16}) {
    probes.values.push_back({fmt::format("{0}x{0}x{0}", side), [volume, side](Options& o) {
                               volume(o);
                               o.prepare.probe_counts = glm::ivec3(side);
                             }});
  }
  axes.push_back(std::move(probes));
  axes.push_back({"probe-rays",
                  "Rays a probe (prepare.probe_rays), with pipeline.object_light.route volume",
                  Judge::kPicture,
                  true,
                  Numbers<int>({64, 256, 1024, 4096},
                               [volume](Options& o, int n) {
                                 volume(o);
                                 o.prepare.probe_rays = n;
                               }),
                  "1024"});
  if (sweep_case.map_width > 0) {
    SweepAxis map{"map-width",
                  "Width of the environment map in pixels (prepare.map_width), with "
                  "pipeline.object_light.route map",
                  Judge::kPicture,
                  false,
                  {},
                  std::to_string(sweep_case.map_width)};
    for (const int part : {16, 8, 4, 2, 1}) {
      if (sweep_case.map_width % part != 0) continue;
      const int width = sweep_case.map_width / part;
      map.values.push_back({std::to_string(width), [width](Options& o) {
                              o.pipeline.object_light.route = ObjectLight::kVolumeByMap;
                              o.prepare.map_width = width;
                            }});
    }
    axes.push_back(std::move(map));
  }
  SweepAxis shadow{
      "shadow",
      "Virtual shadows of the sun: hard (--effects without penumbra, shadow volumes), "
      "or soft with so many points of its disc (pipeline.soft_sun.disc_samples)",
      Judge::kPicture,
      false,
      {{"hard", [](Options& o) { o.pipeline.effects[Effect::kPenumbra] = EffectSwitch::kOff; }}},
      "32"};
  for (SweepValue& value : Numbers<int>(
           {4, 8, 32, 128}, [](Options&o, int n) { o.pipeline.soft_sun.disc_samples = n; })) {
    shadow.values.push_back(std::move(value));
  }
  axes.push_back(std::move(shadow));
  axes.push_back({"influence",
                  "Where the light that objects hide and send is computed (influence_at)",
                  Judge::kPicture,
                  false,
                  {{"pixels", [](Options& o) { o.influence_at = InfluenceAt::kPixels; }},
                   {"faces", [](Options& o) { o.influence_at = InfluenceAt::kFaces; }}},
                  sweep_case.influence_at == InfluenceAt::kFaces ? "faces" : "pixels"});
  axes.push_back({"threshold",
                  "What the effect plan may leave out, in code values "
                  "(pipeline.effects.threshold_code_values)",
                  Judge::kPicture,
                  false,
                  Numbers<double>({0.0, 0.25, 1.0, 4.0, 16.0},
                                  [](Options& o, double codes) {
                                    o.pipeline.effects.threshold_code_values = codes;
                                  }),
                  "1"});
  axes.push_back(
      {"sun-block",
       "Side in pixels of blocks that are lit in the same way (pipeline.view.sun_block_px)",
       Judge::kPicture,
       false,
       Numbers<int>({1, 2, 4, 8}, [](Options& o, int px) { o.pipeline.view.sun_block_px = px; }),
       "1"});
  // At patches' corners there are no blocks.
  if (sweep_case.influence_at == InfluenceAt::kPixels) {
    axes.push_back(
        {"receiver-block",
         "Resolution of the response to sky and bounces: side in pixels of a receiver's "
         "block (pipeline.view.receiver_block_px)",
         Judge::kPicture,
         false,
         Numbers<int>({2, 4, 8, 16},
                      [](Options& o, int px) { o.pipeline.view.receiver_block_px = px; }),
         "4"});
  }
  axes.push_back(
      {"object-samples",
       "Resolution of the objects: side n of a pixel's n^2 + 1 samples "
       "(compositor.object_samples_per_side)",
       Judge::kPicture,
       false,
       Numbers<int>({2, 4, 8}, [](Options& o, int n) { o.compositor.object_samples_per_side = n; }),
       "4"});
}

void AddDaylightAxes(std::vector<SweepAxis>& axes) {
  const auto sampled = [](Options& o) { o.daylight = Daylight::kSamples; };
  SweepAxis light{"light-samples",
                  "Direct daylight (daylight): gathered, or so many samples "
                  "(pipeline.object_light.direct_daylight.sampling.samples)",
                  Judge::kPicture,
                  false,
                  {{"gather", [](Options& o) { o.daylight = Daylight::kGather; }}},
                  "gather"};
  for (SweepValue& value : Numbers<int>({16, 64, 256, 1024}, [sampled](Options&o, int samples) {
         sampled(o);
         o.pipeline.object_light.direct_daylight.sampling.samples = samples;
       })) {
    light.values.push_back(std::move(value));
  }
  axes.push_back(std::move(light));
  axes.push_back({"shadow-map",
                  "Side of a sample's shadow map in pixels, 0: rays "
                  "(pipeline.object_light.direct_daylight.shadows.map_size_px), with "
                  "daylight samples",
                  Judge::kPicture,
                  false,
                  Numbers<int>({16, 32, 64, 128, 0},
                               [sampled](Options& o, int px) {
                                 sampled(o);
                                 o.pipeline.object_light.direct_daylight.shadows.map_size_px = px;
                               }),
                  "64"});
  SweepAxis windows{
      "windows",
      "Where samples are drawn (pipeline.object_light.direct_daylight.sampling.restriction), with "
      "daylight samples and 64 "
      "of them",
      Judge::kPicture,
      false,
      {},
      "windows"};
  for (const auto& [text, restriction] : {std::pair{"windows", DaylightRestriction::kWindows},
                                          std::pair{"rejection", DaylightRestriction::kRejection},
                                          std::pair{"whole-sky", DaylightRestriction::kWholeSky}}) {
    windows.values.push_back({text, [sampled, restriction = restriction](Options& o) {
                                sampled(o);
                                o.pipeline.object_light.direct_daylight.sampling.samples = 64;
                                o.pipeline.object_light.direct_daylight.sampling.restriction =
                                    restriction;
                              }});
  }
  axes.push_back(std::move(windows));
}

void AddRegionAxis(std::vector<SweepAxis>& axes) {
  SweepAxis regions{"regions",
                    "Regions that the fish-eye's sky is averaged over (sky_regions)",
                    Judge::kPicture,
                    false,
                    {},
                    "picture"};
  for (const auto& [bands, sectors] :
       {std::pair{1, 1}, std::pair{2, 8}, std::pair{4, 16}, std::pair{8, 32}}) {
    regions.values.push_back(
        {std::to_string(bands) + "x" + std::to_string(sectors),
         [cut = SkyRegions(bands, sectors)](Options& o) { o.sky_regions = cut; }});
  }
  regions.values.push_back({"picture", [](Options& o) { o.sky_regions.reset(); }});
  axes.push_back(std::move(regions));
}

}  // namespace

std::vector<SweepAxis> SweepAxesFor(const SweepCase& sweep_case) {
  std::vector<SweepAxis> axes;
  if (sweep_case.light_is_fitted) {
    AddFitAxes(axes);
    AddModelAxes(axes);
  }
  if (sweep_case.light_is_fitted || sweep_case.has_pictures) AddOfflineAxes(sweep_case, axes);
  if (!sweep_case.has_pictures) return axes;
  if (!sweep_case.light_is_fitted) AddRegionAxis(axes);
  AddPictureAxes(sweep_case, axes);
  if (sweep_case.is_indoors) AddDaylightAxes(axes);
  return axes;
}

}  // namespace pleinair
