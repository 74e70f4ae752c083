// Blurs virtual objects and their shadows by what moves while the frame is exposed.
#include <algorithm>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/motion_track.h"
#include "scene/exposure_motion.h"

namespace pleinair {
namespace {

float LargestOf(const glm::vec3& rgb) { return std::max({rgb.r, rgb.g, rgb.b}); }

// The nearest object of the samples of each pixel, and its depth.
ObjectDepths DepthsOf(const ObjectView& view, const Mesh& objects, const Camera& camera) {
  constexpr int kSide = ObjectView::kSamplesPerSide;
  ObjectDepths depths{view.x_px, view.y_px, {}, {}};
  depths.object = Image<std::int32_t>(view.width_px, view.height_px, ObjectDepths::kNone);
  depths.depth_m = GrayImage(view.width_px, view.height_px);
  const glm::mat4 camera_from_world(camera.camera_from_world);
  for (int y = 0; y < kSide * view.height_px; ++y) {
    for (int x = 0; x < kSide * view.width_px; ++x) {
      const ObjectView::Sample& sample = view.samples.At(x, y);
      if (sample.triangle == ObjectView::kNothing) continue;
      const glm::uvec3& corners = objects.triangles[sample.triangle];
      const glm::vec2& at = sample.barycentric;
      const glm::vec3 place = (1.0f - at.x - at.y) * objects.positions_m[corners.x] +
                              at.x * objects.positions_m[corners.y] +
                              at.y * objects.positions_m[corners.z];
      const float depth = (camera_from_world * glm::vec4(place, 1.0f)).z;
      std::int32_t& object = depths.object.At(x / kSide, y / kSide);
      float& nearest = depths.depth_m.At(x / kSide, y / kSide);
      if (object != ObjectDepths::kNone && !(depth < nearest)) continue;
      object = static_cast<std::int32_t>(objects.triangle_group[sample.triangle]);
      nearest = depth;
    }
  }
  return depths;
}

class MotionBlurOfObjects : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    const MotionBlurOptions& options = stage_.Options().motion_blur;
    const std::vector<BoundingBox>& boxes = stage_.ObjectBoxes();
    MotionTrack::Found found = track_.At({frame.frame.time,
                                          frame.frame.camera,
                                          {frame.object_poses.begin(), frame.object_poses.end()},
                                          boxes});
    const double stated_s = frame.frame.exposure_s.value_or(options.exposure_s);
    in_picture_.motion = {found.known_s > 0.0 ? std::min(stated_s, found.known_s) : stated_s,
                          options.readout_s,
                          found.camera,
                          std::move(found.objects)};
    const ExposureMotion& motion = in_picture_.motion;
    if (!(motion.exposure_s > 0.0) && !(motion.readout_s > 0.0)) return {0.0, "no exposure time"};
    if (!motion.Moves()) return {0.0, found.why_still};
    // A pixel is a mean over a square: from pixel to pixel it changes by all of the light at most,
    // along each axis. Shadows may be nearer to the camera than objects, and longer.
    constexpr double kOfShadows = 4.0;
    const double mean_s = 0.25 * motion.exposure_s + 0.5 * motion.readout_s;
    const double shift_px = LargestShiftPx(motion, frame.frame.camera, boxes, mean_s);
    const double share = std::min(kOfShadows * std::numbers::sqrt2 * shift_px, 1.0);
    if (stage_.AnyGlossy()) return {share > 0.0 ? kWhiteCode : 0.0, "motion of what may glint"};
    const std::vector<glm::vec3>& pixels = frame.radiance.pixels;
    const float of_camera = LargestOver(pixels.size(), [&](std::size_t i) {
      return LargestOf(pixels[i]) < 1e30f ? LargestOf(pixels[i]) : 0.0f;
    });
    const glm::vec3 on_objects = stage_.LargestIrradianceOnObjects(frame) + SunOf(frame.lighting);
    const float brightest =
        std::max(of_camera, LargestOf(kInvPi * stage_.LargestAlbedo() * on_objects));
    const glm::vec3 change(static_cast<float>(share) * brightest);
    return {std::min(kWhiteCode, double{frame.codes.LargestRise(glm::vec3(0.0f), change)}),
            "motion during the exposure"};
  }
  // Shadows of objects out of view may still be in view.
  EffectSet PartOf(const EffectFrame& frame) override {
    return stage_.InView(frame) ? EffectSet() : kOnSurfaces;
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    works.push_back(WorkOf(
        "objects in motion", stage_.ViewOfObjects().Cost(frame), frame, {Effect::kMotionBlur}));
    works.back().make = [this, &frame](EffectSet) {
      if (!in_picture_.motion.Moves()) return;
      const PatchScene& objects = stage_.Objects();
      in_picture_.objects =
          DepthsOf(stage_.ViewOfObjects().Update(objects, frame), objects.mesh, frame.view.camera);
    };
    works.push_back(DrawingOf("draw motion", kDrawMs, frame, {Effect::kMotionBlur}));
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    if (in_picture_.motion.Moves()) input.motion = &in_picture_;
  }

 private:
  static constexpr double kDrawMs = 4.0;  // Nominal, over 8 pixels: see kDrawObjectsMs.

  MotionTrack track_;
  MotionInPicture in_picture_;
};

}  // namespace

const EffectDefinition kMotionBlurEffect{
    .name = "motion-blur",
    .help = "objects and shadows blurred by motion during the exposure",
    .rms_share = 0.02,
    .make = MakeEffect<MotionBlurOfObjects>};

}  // namespace pleinair
