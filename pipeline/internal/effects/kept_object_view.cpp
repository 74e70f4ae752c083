#include "pipeline/internal/effects/kept_object_view.h"

#include "scene/stopwatch.h"

namespace pleinair {

WorkCost KeptObjectView::Cost(const EffectFrame& frame) const {
  if (view_.IsOf(frame.Geometry())) return {.is_kept = true};
  return {.expected_ms = cost_.Ms(), .nominal_ms = cost_.NominalMs(), .once_ms = cost_.Ms()};
}

const ObjectView& KeptObjectView::Update(const PatchScene& objects, const EffectFrame& frame) {
  return view_.Get(frame.Geometry(), [&] {
    Stopwatch watch;
    ObjectView view = SeeObjects(objects, frame.view.camera);
    cost_.Learn(watch.LapMs());
    return view;
  });
}

}  // namespace pleinair
