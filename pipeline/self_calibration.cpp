#include "pipeline/self_calibration.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "estimation/camera_errors.h"
#include "estimation/lighting_prior.h"
#include "estimation/sample_noise.h"
#include "estimation/sample_selection.h"
#include "pipeline/frame_view.h"
#include "pipeline/internal/middle_frames.h"
#include "pipeline/sun_state.h"
#include "relight/surface_view_builder.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

// Samples are drawn from a view of this albedo everywhere: none is an outlier, all are equal.
constexpr float kDrawnAlbedo = 0.5f;
constexpr float kLeastAlbedo = 0.01f;
constexpr float kLargestAlbedo = 0.98f;  // As the survey has it.

// Running numbers for keys as they come.
template <class Key>
class Numbered {
 public:
  std::int32_t Of(const Key& key) {
    return numbers_.emplace(key, static_cast<std::int32_t>(numbers_.size())).first->second;
  }
  const std::map<Key, std::int32_t>& All() const { return numbers_; }

 private:
  std::map<Key, std::int32_t> numbers_;
};

struct SurfaceKey {
  std::int32_t plane;  // DiffuseSample::plane: group and facing.
  std::uint32_t material;
  bool operator<(const SurfaceKey& other) const {
    return std::tie(plane, material) < std::tie(other.plane, other.material);
  }
};

bool IsWanted(int index, std::optional<int> count, int wanted) {
  return count ? IsMiddleOfAPart(index, *count, wanted) : index < wanted;
}

class SelfCalibrator {
 public:
  SelfCalibrator(const std::optional<Site>& site,
                 const SelfCalibrationOptions& options,
                 PreparedScene& scene)
      : site_(site), options_(options), scene_(scene), clear_sky_(site, nullptr) {}

  // One round: light between surfaces under the albedos of the scene, then the albedos.
  SelfCalibration Round(FrameSource& source) {
    frames_.clear();
    surfaces_ = {};
    spots_ = {};
    shapes_.assign(options_.sky_shapes.size(), nullptr);
    SurfaceViewOptions view_options;
    view_options.receiver_block_px = options_.receiver_block_px;
    SurfaceViewBuilder builder(scene_, view_options);
    std::string last_error = "the recording is empty";
    const std::optional<int> count = source.Count();
    for (int index = 0;; ++index) {
      const auto next = source.Next();
      if (!next) break;
      if (!IsWanted(index, count, options_.frames)) continue;
      if (!*next) {
        last_error = next->error().reason;
        continue;
      }
      // A frame that cannot be used is reported when it is run.
      try {
        AddFrame(**next, builder);
      } catch (const std::exception& error) {
        last_error = error.what();
      }
    }
    if (spots_.All().empty()) {
      throw std::runtime_error("self-calibration: no frame shows a diffuse surface (" + last_error +
                               "): expected one, or the setting albedo=materials");
    }
    std::vector<glm::dvec3> expected(surfaces_.All().size());
    for (const auto& [key, surface] : surfaces_.All()) {
      expected[static_cast<std::size_t>(surface)] = ExpectedAlbedo(key.material);
    }
    const JointAlbedo found = FitAlbedoAndLight(frames_, expected, options_.joint);
    SetFaces(found);

    SelfCalibration result;
    result.frames = static_cast<int>(frames_.size());
    result.surfaces = static_cast<int>(expected.size());
    result.colour_from_sun = found.colour_from_sun;
    result.converged = found.converged;
    std::vector<double> deviations;
    for (const glm::dvec3& stddev : found.surface_stddev_rgb) {
      deviations.insert(deviations.end(), {stddev.x, stddev.y, stddev.z});
    }
    result.surface_stddev = UpperMedianInPlace(deviations);
    return result;
  }

 private:
  const std::optional<Site>& site_;
  const SelfCalibrationOptions& options_;
  PreparedScene& scene_;
  ScaledClearSky clear_sky_;
  std::vector<std::shared_ptr<const SkyShape>> shapes_;
  std::vector<AlbedoFrame> frames_;
  Numbered<SurfaceKey> surfaces_;
  Numbered<std::pair<std::int32_t, std::int32_t>> spots_;  // Surface and face.
  std::vector<DiffuseSample> samples_;

  glm::dvec3 ExpectedAlbedo(std::uint32_t material) const {
    if (options_.mean_albedo) return glm::dvec3(*options_.mean_albedo);
    return glm::clamp(glm::dvec3(scene_.patches.mesh.materials[material].diffuse_albedo),
                      double{kLeastAlbedo},
                      double{kLargestAlbedo});
  }

  void AddFrame(const Frame& frame, SurfaceViewBuilder& builder) {
    const SunState sun = SunOfFrame(site_, frame);
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      const SkyShapeKind kind = options_.sky_shapes[k];
      if (shapes_[k] == nullptr || TurnsWithTheSun(kind)) {
        shapes_[k] = MakeSkyShape(kind, sun.direction_enu, scene_.aerosol_optical_depth_500nm);
      }
    }
    SurfaceView view = builder.Update(
        frame.camera, sun.direction_enu, sun.angular_radius_rad, shapes_, SampleRegionsOf(frame));
    std::fill(
        view.albedo_rgb.pixels.begin(), view.albedo_rgb.pixels.end(), glm::vec3(kDrawnAlbedo));
    view.geometry_id = StateId::Next();
    SampleSet set;
    set.Draw(
        view, sun.direction_enu, frame.radiance, frame.unusable, {options_.samples, options_.seed});
    set.Measure(sun.direction_enu, frame.radiance, frame.unusable, samples_);
    if (frame.noise != nullptr) {
      ApplySignalNoise(*frame.noise, frame.exposure.value_or(1.0), samples_);
    }

    AlbedoFrame& added = frames_.emplace_back();
    ClearSkyExpectation clear_sky = clear_sky_.At(sun.direction_enu);
    clear_sky.absolute = false;
    added.prior = MakeClimatePrior(clear_sky, static_cast<int>(shapes_.size()), frame.weather);
    SetBeamShape(view.sky_shape_names, clear_sky, added.prior);
    // A camera that states its exposure has errors too small to distinguish from the albedos'.
    if (frame.units == LightUnits::kRelativePerFrame) {
      added.prior.camera = ExpectedCameraErrors(frame);
    }
    added.sun_is_up = sun.direction_enu.z > -std::sin(sun.angular_radius_rad);
    // A white balance that is not known has no colour to compare.
    if (frame.units == LightUnits::kAbsolute) added.clear_beam_rgb = clear_sky.beam_rgb;
    for (DiffuseSample& sample : samples_) {
      sample.sun_transport_rgb /= double{kDrawnAlbedo};
      for (glm::dvec3& sky : sample.sky_transport_rgb) sky /= double{kDrawnAlbedo};
      const std::int32_t face =
          scene_.patches.FaceOfSide(builder.PixelSides().At(sample.pixel.x, sample.pixel.y));
      const std::uint32_t material = scene_.patches.MaterialOf(static_cast<std::size_t>(face) / 2);
      const std::int32_t surface = surfaces_.Of({sample.plane, material});
      added.samples.push_back({sample, surface, spots_.Of({surface, face})});
    }
  }

  struct Sum {
    glm::dvec3 albedo{0.0};
    double weight = 0.0;
  };

  void SetFaces(const JointAlbedo& found) {
    PatchScene& patches = scene_.patches;
    std::map<std::pair<std::uint32_t, std::uint32_t>, Sum> of_group;
    std::map<std::uint32_t, Sum> of_material;
    std::vector<std::uint8_t> seen(patches.FaceCount(), 0);
    for (const auto& [key, spot] : spots_.All()) {
      const auto face = static_cast<std::size_t>(key.second);
      const glm::dvec3 albedo = glm::clamp(found.spot_albedo_rgb[static_cast<std::size_t>(spot)],
                                           double{kLeastAlbedo},
                                           double{kLargestAlbedo});
      patches.face_albedo_rgb[face] = glm::vec3(albedo);
      seen[face] = 1;
      const double area_m2 = patches.PatchAreaM2(face / 2);
      const std::uint32_t material = patches.MaterialOf(face / 2);
      for (Sum* sum : {&of_group[{patches.GroupOf(face / 2), material}], &of_material[material]}) {
        sum->albedo += area_m2 * albedo;
        sum->weight += area_m2;
      }
    }
    for (std::size_t face = 0; face < seen.size(); ++face) {
      if (seen[face] != 0) continue;
      const std::uint32_t material = patches.MaterialOf(face / 2);
      const auto group = of_group.find({patches.GroupOf(face / 2), material});
      const auto same = of_material.find(material);
      const Sum* sum = group != of_group.end()     ? &group->second
                       : same != of_material.end() ? &same->second
                                                   : nullptr;
      patches.face_albedo_rgb[face] =
          glm::vec3(sum != nullptr ? sum->albedo / sum->weight : ExpectedAlbedo(material));
    }
  }
};

std::string Percent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

}  // namespace

void SelfCalibrationOptions::Validate() const {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument(what); };
  if (frames < 1) refuse("frames is " + std::to_string(frames) + ": expected at least 1");
  if (rounds < 1) refuse("rounds is " + std::to_string(rounds) + ": expected at least 1");
  if (sky_shapes.empty()) refuse("sky_shapes: expected at least one");
  if (mean_albedo && !(*mean_albedo > 0.0 && *mean_albedo <= 1.0)) {
    refuse("mean_albedo is " + std::to_string(*mean_albedo) + ": expected one in (0, 1]");
  }
  SampleSelectionOptions{samples, seed}.Validate();
  joint.Validate();
}

SelfCalibration SelfCalibrateAlbedo(
    const std::function<std::unique_ptr<FrameSource>()>& open_frames,
    const std::optional<Site>& site,
    const SelfCalibrationOptions& options,
    PreparedScene& scene) {
  options.Validate();
  if (scene.survey) {
    throw std::invalid_argument("self-calibration: the scene has a survey: expected none");
  }
  if (options.mean_albedo) {
    for (glm::vec3& albedo : scene.patches.face_albedo_rgb) {
      albedo = glm::vec3(static_cast<float>(*options.mean_albedo));
    }
  }
  SelfCalibrator calibrator(site, options, scene);
  SelfCalibration result;
  for (int round = 0; round < options.rounds; ++round) {
    result = calibrator.Round(*open_frames());
  }
  scene.albedo_stddev_rgb = glm::dvec3(options.joint.expected_stddev);
  scene.notes.push_back(
      "albedos of " + std::to_string(result.surfaces) +
      " surfaces found together with the light of " + std::to_string(result.frames) +
      " frames; against each other +/- " + Percent(result.surface_stddev) + ", all together " +
      Percent(options.joint.expected_stddev) + ": their mean is taken to be " +
      (options.mean_albedo ? std::to_string(*options.mean_albedo).substr(0, 4)
                           : std::string("the materials' own")) +
      (result.colour_from_sun ? ", their colour from the clear-sky beam's"
                              : ", their colour the materials' own: where that is wrong, the "
                                "light's is, too (a survey map would determine it)") +
      (result.converged ? "" : "; still moving when stopped"));
  return result;
}

}  // namespace pleinair
