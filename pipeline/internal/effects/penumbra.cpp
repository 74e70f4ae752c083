// Soft edges of the sun's shadows: the disc is half a degree wide.
#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/lighting_source.h"
#include "objects/learned_cost.h"
#include "objects/shadow_places.h"
#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/seen_shade.h"
#include "scene/angle_between.h"
#include "scene/cached.h"
#include "scene/stopwatch.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

struct Done {};
// The part of the objects' share of the sun that is computed from the mesh alone.
struct PastMesh {
  ObjectSunShare share;
  SeenShade seen_shade;
};

// The shade that was seen last, and from where. Empty: none was.
struct LastShade {
  ViewOfPose view;
  glm::dvec3 to_sun{0.0};
  GrayImage left;

  // `shade`: null where none is seen.
  void See(const EffectFrame& frame, const GrayImage* shade) {
    view = frame.Geometry();
    to_sun = frame.basis.Sun().direction_enu;
    if (shade == nullptr) {
      left = GrayImage();
    } else {
      left = *shade;
    }
  }
  // A sun that has moved farther, 20 minutes by day, casts other shadows.
  bool HoldsFor(const EffectFrame& frame) const {
    constexpr double kFarthestRad = RadFromDeg(5.0);
    return !left.Empty() && view == frame.Geometry() &&
           AngleBetweenRad(to_sun, frame.basis.Sun().direction_enu) < kFarthestRad;
  }
};

class Penumbra : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  // The bounds of the shadows whose edges are soft.
  Bound BoundOf(const EffectFrame& /*frame*/, std::span<const EffectOffer> before) override {
    const EffectOffer& cast = before[static_cast<std::size_t>(Effect::kSunShadow)];
    const EffectOffer& on_objects = before[static_cast<std::size_t>(Effect::kObjectShadow)];
    const bool is_cast = cast.bound_code_values > on_objects.bound_code_values;
    const EffectOffer& larger = is_cast ? cast : on_objects;
    if (larger.bound_code_values == 0.0) return {0.0, "no shadow of the sun"};
    return {larger.bound_code_values, larger.why};
  }
  EffectSet PartOf(const EffectFrame& /*frame*/) override {
    return {Effect::kSunShadow, Effect::kObjectShadow};
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    works.push_back(WorkOf("objects in view",
                           stage_.ViewOfObjects().Cost(frame),
                           frame,
                           {Effect::kPenumbra, Effect::kGlossyReflection}));
    works.back().make = [this, &frame](EffectSet runs) {
      // Soft shadows on real surfaces do without.
      if (runs.HasAny({Effect::kObjectShadow, Effect::kGlossyReflection})) {
        stage_.ViewOfObjects().Update(stage_.Objects(), frame);
      }
    };
    works.push_back(
        WorkOf("sun past objects", CostOf(real_, real_cost_, frame), frame, {Effect::kSunShadow}));
    works.back().offer.with_all = {Effect::kPenumbra};
    works.back().make = [this, &frame](EffectSet) { UpdateReal(frame); };
    works.push_back(WorkOf("sun on objects",
                           CostOf(on_objects_, object_cost_, frame),
                           frame,
                           {Effect::kObjectShadow}));
    works.back().offer.with_all = {Effect::kPenumbra};
    works.back().make = [this, &frame](EffectSet) { UpdateObjects(frame); };
    works.push_back(
        WorkOf("seen shade on objects", CostOfSeenShade(frame), frame, {Effect::kObjectShadow}));
    works.back().offer.with_all = {Effect::kPenumbra};
    works.back().sum = [this, &frame](EffectSet) { TakeSeenShade(frame); };
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.sun_shares = &shares_;
  }

 private:
  template <class Made>
  static WorkCost CostOf(const Cached<Made, ViewOfPose>& made,
                         const LearnedCost& cost,
                         const EffectFrame& frame) {
    if (made.IsOf(frame.UnderSun())) return {.is_kept = true};
    return {.expected_ms = cost.Ms(), .nominal_ms = cost.NominalMs(), .sun_ms = cost.Ms()};
  }

  void UpdateReal(const EffectFrame& frame) {
    real_.Get(frame.UnderSun(), [&] {
      Stopwatch watch;
      shares_.real = stage_.SunPastObjects().OnReal(frame.view, frame.basis.Sun());
      real_cost_.Learn(watch.LapMs());
      return Done();
    });
  }
  void UpdateObjects(const EffectFrame& frame) {
    on_objects_.Get(frame.UnderSun(), [&] {
      const ObjectView& view = stage_.ViewOfObjects().Update(stage_.Objects(), frame);
      Stopwatch watch;
      PastMesh past_mesh;
      past_mesh.share = stage_.SunPastObjects().OnObjects(view, frame.basis.Sun());
      past_mesh.seen_shade = SeenShade(ShadowPlacesOf(view,
                                                      stage_.Objects(),
                                                      stage_.RealSurfaces(),
                                                      frame.view,
                                                      glm::vec3(frame.basis.Sun().direction_enu)),
                                       {frame.view.Width(), frame.view.Height()});
      is_past_mesh_ = false;
      object_cost_.Learn(watch.LapMs());
      return past_mesh;
    });
  }
  // In light that is hardly known, dark surfaces would count as shade. Less than a code value of
  // the sun on the objects needs no search.
  bool MayShowShade(const EffectFrame& frame) {
    return LightIsKnown(frame.lighting) && SunOnObjects(stage_, frame).code_values >= 1.0;
  }
  WorkCost CostOfSeenShade(const EffectFrame& frame) {
    if (!MayShowShade(frame)) return {.is_kept = true};
    return {.expected_ms = seen_shade_cost_.Ms(), .nominal_ms = seen_shade_cost_.NominalMs()};
  }
  // Repeated for each picture: shade also moves when camera and sun do not, as that of trees in the
  // wind, cars and people does. Where it cannot be seen, the last that was seen from there is held:
  // a house still stands while a cloud makes the light uncertain.
  void TakeSeenShade(const EffectFrame& frame) {
    PastMesh& past_mesh = on_objects_.Kept();
    const GrayImage* left = nullptr;
    if (MayShowShade(frame)) {
      Stopwatch watch;
      left = past_mesh.seen_shade.SunLeft(frame);
      last_shade_.See(frame, left);
      seen_shade_cost_.Learn(watch.LapMs());
    } else if (!LightIsKnown(frame.lighting) && last_shade_.HoldsFor(frame)) {
      left = &last_shade_.left;
    }
    if (left != nullptr) TakeSun(past_mesh.share, *left, shares_.objects);
    if (left == nullptr && !is_past_mesh_) shares_.objects = past_mesh.share;
    is_past_mesh_ = left == nullptr;
  }

  SunShares shares_;
  Cached<Done, ViewOfPose> real_;  // In shares_.
  Cached<PastMesh, ViewOfPose> on_objects_;
  LearnedCost real_cost_{4.0};
  LearnedCost object_cost_{4.0};
  LearnedCost seen_shade_cost_{1.0};
  LastShade last_shade_;
  bool is_past_mesh_ = false;  // shares_.objects is on_objects_'s share.
};

}  // namespace

const EffectDefinition kPenumbraEffect{.name = "penumbra",
                                       .help = "soft edges of the sun's shadows",
                                       .rms_share = 0.016,
                                       .make = MakeEffect<Penumbra>};

}  // namespace pleinair
