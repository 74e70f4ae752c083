// The light that a picture is drawn in where nothing shows whether the sun shines.
#pragma once

#include <optional>

#include "estimation/lighting_source.h"
#include "scene/lighting.h"
#include "scene/utc_time.h"

namespace pleinair {

// Returns the light that is likely without a sun: the mean of the sky under `lighting`'s normal
// distribution, given that the sun is 0. The factor that all light shares is left out of it. So
// level ground of which only the brightness is known keeps it, and a sky that is known by itself
// stays. Each channel by itself. Deviations of the sky stay those of `lighting`; without a
// covariance only the sun is removed.
Lighting LightWithoutSun(const Lighting& lighting);

// An object's hard shadow would be the only one in a picture that shows neither sun nor shade, and
// is wrong under cloud. The estimate of such a frame is a mean over the weathers, in which the sun
// is never 0. So it is drawn without a sun, unless the sun is likely, or another frame's light was
// known less than an hour before or after. Not for a source that does not estimate the weather, nor
// where picture and model do not fit.
//
// Takes a camera's frames one after another. One thread at a time.
class UnprovenSun {
 public:
  // Returns the light to draw the frame in; none where it is the estimate's. `is_held`: the light
  // is that of the frames before, and so is the answer.
  std::optional<Lighting> Without(const LightingEstimate& estimate, bool is_held = false);

 private:
  std::optional<Lighting> WithoutUnlessHeld(const LightingEstimate& estimate);

  std::optional<UtcTime> last_known_;
  bool was_without_ = true;  // As far as that was asked.
  bool is_drawn_without_ = false;
};

}  // namespace pleinair
