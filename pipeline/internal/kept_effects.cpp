#include "pipeline/internal/kept_effects.h"

#include <algorithm>
#include <vector>

#include "scene/stopwatch.h"

namespace pleinair {
namespace {

constexpr WorkCost kNone{.is_kept = true};

WorkCost OfSun(const LearnedCost& cost) {
  return {.expected_ms = cost.Ms(), .nominal_ms = cost.NominalMs(), .sun_ms = cost.Ms()};
}

// Of something gathered for a geometry, then worked out light by light, then summed.
WorkCost CostOf(const LearnedCost& gather,
                const LearnedCost& light,
                const LearnedCost& sum,
                bool is_new,
                std::size_t lights) {
  const auto count = static_cast<double>(lights);
  return {(is_new ? gather.Ms() : 0.0) + count * light.Ms() + sum.Ms(),
          (is_new ? gather.NominalMs() : 0.0) + count * light.NominalMs() + sum.NominalMs(),
          !is_new && lights == 0,
          is_new ? gather.Ms() + count * light.Ms() : 0.0,
          is_new ? 0.0 : count * light.Ms()};
}

// Lights that were never worked out are, even if they do not shine, so that the sum over all of
// them is defined; those are not done.
std::vector<std::size_t> LightsToDo(const LightsDone& done,
                                    bool is_new,
                                    const FrameBasis& basis,
                                    const Lighting& lighting,
                                    Upto upto = Upto::kCurrent) {
  if (!is_new) return done.StaleIn(basis, lighting, upto);
  std::vector<std::size_t> all(basis.LightCount());
  for (std::size_t light = 0; light < all.size(); ++light) all[light] = light;
  return all;
}

bool Shines(const Lighting& lighting, std::size_t light) {
  return IntensityOf(lighting, light) != glm::vec3(0.0f);
}

// Adds lights whose light on the objects has been made anew since.
void AddRemade(const LightsDone& source,
               const std::vector<std::uint64_t>& made_from,
               const Lighting& lighting,
               std::vector<std::size_t>& lights) {
  for (std::size_t light = 0; light < made_from.size(); ++light) {
    if (!Shines(lighting, light) || made_from[light] == source.Version(light)) continue;
    if (std::find(lights.begin(), lights.end(), light) == lights.end()) lights.push_back(light);
  }
}

}  // namespace

WorkCost KeptObjectView::Cost(const SurfaceView& view) const {
  if (version_ == view.geometry_version) return kNone;
  return {.expected_ms = cost_.Ms(), .nominal_ms = cost_.NominalMs(), .once_ms = cost_.Ms()};
}

void KeptObjectView::Update(const PatchScene& objects, const SurfaceView& view) {
  if (version_ == view.geometry_version) return;
  Stopwatch watch;
  object_view_ = SeeObjects(objects, view.camera);
  version_ = view.geometry_version;
  cost_.Learn(watch.LapMs());
}

WorkCost KeptSunShares::RealCost(const SurfaceView& view) const {
  return real_version_ == view.sun_version ? kNone : OfSun(real_cost_);
}

WorkCost KeptSunShares::ObjectCost(const SurfaceView& view) const {
  return object_version_ == view.sun_version ? kNone : OfSun(object_cost_);
}

void KeptSunShares::UpdateReal(const SoftSun& soft_sun,
                               const SurfaceView& view,
                               const DirectionalLight& sun) {
  if (real_version_ == view.sun_version) return;
  Stopwatch watch;
  shares_.real = soft_sun.OnReal(view, sun);
  real_version_ = view.sun_version;
  real_cost_.Learn(watch.LapMs());
}

void KeptSunShares::UpdateObjects(const SoftSun& soft_sun,
                                  const SurfaceView& view,
                                  const ObjectView& objects,
                                  const DirectionalLight& sun) {
  if (object_version_ == view.sun_version) return;
  Stopwatch watch;
  shares_.objects = soft_sun.OnObjects(objects, sun);
  object_version_ = view.sun_version;
  object_cost_.Learn(watch.LapMs());
}

WorkCost KeptInfluence::Cost(const SurfaceView& view,
                             const FrameBasis& basis,
                             const Lighting& lighting,
                             VertexLight::Mode light) const {
  const bool is_new_view = geometry_version_ != view.geometry_version;
  const bool is_new = IsNew(view, basis);
  const LightsDone done = light == light_ ? done_ : LightsDone();
  const std::size_t lights = LightsToDo(done, is_new, basis, lighting).size();
  WorkCost cost = CostOf(gather_cost_, light_cost_, sum_cost_, is_new, lights);
  if ((is_new || is_new_view) && OnFaces()) {
    cost.expected_ms += see_cost_.Ms();
    cost.nominal_ms += see_cost_.NominalMs();
    cost.is_kept = false;
  }
  return cost;
}

void KeptInfluence::Update(const PreparedScene& scene,
                           const SurfaceView& view,
                           const Image<std::int32_t>& pixel_faces,
                           const FrameBasis& basis,
                           const Lighting& lighting,
                           const FramePipelineOptions& options,
                           VertexLight& vertex_light) {
  const bool is_new_view = geometry_version_ != view.geometry_version;
  const bool is_new = IsNew(view, basis);
  Stopwatch watch;
  if (is_new) {
    const PatchScene& objects = vertex_light.Objects();
    geometry_version_.reset();
    done_.Forget();
    influence_ = OnFaces() ? ObjectInfluence(scene.patches, objects, options.influence)
                           : ObjectInfluence(scene.patches, objects, view, options.influence);
    gather_cost_.Learn(watch.LapMs());
  }
  if (light_ != vertex_light.UpdatedIn()) done_.Forget();
  light_ = vertex_light.UpdatedIn();
  if ((is_new || is_new_view) && OnFaces()) {
    influence_.See(scene.patches, view, pixel_faces);
    see_cost_.Learn(watch.LapMs());
  }
  std::vector<std::size_t> lights = LightsToDo(done_, is_new, basis, lighting);
  const LightsDone& source = vertex_light.Done(light_);
  made_from_.resize(basis.LightCount(), 0);
  AddRemade(source, made_from_, lighting, lights);
  geometry_version_ = view.geometry_version;
  lights_ = basis.LightCount();
  if (lights.empty()) return;
  const std::vector<Receiver> receivers =
      vertex_light.Daylight() != nullptr ? influence_.Receivers() : std::vector<Receiver>();
  for (const std::size_t light : lights) {
    const std::vector<glm::vec3> object_radiosity = vertex_light.ObjectRadiosity(basis, light);
    const bool is_sampled = light > 0 && vertex_light.Daylight() != nullptr;
    influence_.Fold(light,
                    is_sampled ? nullptr : basis.Sky(light),
                    view,
                    basis.FaceRadiosity(light),
                    object_radiosity,
                    vertex_light.SampledSkyHiddenFrom(basis, light, receivers));
    if (Shines(lighting, light)) done_.Done(basis, light);
    made_from_[light] = source.Version(light);
  }
  light_cost_.Learn(watch.LapMs() / static_cast<double>(lights.size()));
}

void KeptInfluence::Evaluate(const Lighting& lighting, const InfluenceParts& parts) {
  Stopwatch watch;
  influence_.Evaluate(lighting, parts, change_);
  sum_cost_.Learn(watch.LapMs());
}

LightCost KeptMirror::Cost(const SurfaceView& view,
                           const FrameBasis& basis,
                           const Lighting& lighting,
                           VertexLight::Mode light) const {
  const bool is_new = IsNew(view, basis);
  const LightsDone done = light == light_ ? done_ : LightsDone();
  const std::size_t all = LightsToDo(done, is_new, basis, lighting, Upto::kCurrent).size();
  const std::size_t lacking = LightsToDo(done, is_new, basis, lighting, Upto::kLacking).size();
  LightCost cost;
  cost.lacking = CostOf(gather_cost_, light_cost_, sum_cost_, is_new, lacking);
  cost.lacking.is_kept = !is_new && all == 0;
  cost.now.is_kept = true;
  if (all > lacking) {
    const auto older = static_cast<double>(all - lacking);
    cost.now.expected_ms = cost.now.sun_ms = older * light_cost_.Ms();
    cost.now.is_kept = false;
    cost.now.nominal_ms = older * light_cost_.NominalMs();
  }
  return cost;
}

void KeptMirror::Update(const PreparedScene& scene,
                        const SurfaceView& view,
                        const ObjectView& object_view,
                        const FrameBasis& basis,
                        const Lighting& lighting,
                        const MirrorImageOptions& options,
                        Upto upto,
                        VertexLight& vertex_light) {
  const bool is_new = IsNew(view, basis);
  const PatchScene& objects = vertex_light.Objects();
  Stopwatch watch;
  if (is_new) {
    geometry_version_.reset();
    done_.Forget();
    mirror_ = MirrorImage(
        scene.patches, objects, object_view, scene.survey ? &*scene.survey : nullptr, options);
    gather_cost_.Learn(watch.LapMs());
  }
  if (light_ != vertex_light.UpdatedIn()) done_.Forget();
  light_ = vertex_light.UpdatedIn();
  std::vector<std::size_t> lights = LightsToDo(done_, is_new, basis, lighting, upto);
  const LightsDone& source = vertex_light.Done(light_);
  made_from_.resize(basis.LightCount(), 0);
  AddRemade(source, made_from_, lighting, lights);
  geometry_version_ = view.geometry_version;
  lights_ = basis.LightCount();
  for (const std::size_t light : lights) {
    const std::vector<glm::vec3> object_radiosity = vertex_light.ObjectRadiosity(basis, light);
    MirroredBasis of_light;
    of_light.sky = basis.Sky(light);
    of_light.real_radiosity = basis.FaceRadiosity(light);
    of_light.object_radiosity = object_radiosity;
    if (light == 0) of_light.real_direct = basis.DirectIrradiance();
    of_light.sun = basis.Sun();
    mirror_.Fold(light, of_light, scene.patches, objects);
    if (Shines(lighting, light)) done_.Done(basis, light);
    made_from_[light] = source.Version(light);
  }
  if (!lights.empty()) light_cost_.Learn(watch.LapMs() / static_cast<double>(lights.size()));
}

void KeptMirror::Evaluate(const Lighting& lighting) {
  Stopwatch watch;
  mirror_.Evaluate(lighting, image_);
  sum_cost_.Learn(watch.LapMs());
}

}  // namespace pleinair
