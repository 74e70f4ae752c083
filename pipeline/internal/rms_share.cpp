#include "pipeline/internal/rms_share.h"

#include <algorithm>

#include "sunmodel/angles.h"

namespace pleinair {

double RmsShareOf(Effect effect) {
  switch (effect) {
    case Effect::kProbeShading:
      return 0.3;
    case Effect::kSunShading:
    case Effect::kDaylight:  // Not measured: what the sun is outdoors it is in a room.
      return 0.2;
    case Effect::kGlossyReflection:
      return 0.13;
    case Effect::kSunShadow:
      return 0.12;
    case Effect::kObjectShadow:
      return 0.1;
    case Effect::kCurrentLight:
      return 0.03;
    case Effect::kSkyOcclusion:
      return 0.025;
    case Effect::kSelfOcclusion:
      return 0.02;
    case Effect::kPenumbra:
    case Effect::kColourBleeding:
      return 0.016;
    case Effect::kLightVariation:
    case Effect::kCameraBlur:
      return 0.01;
    case Effect::kCameraNoise:
      return 0.005;
  }
  return 1.0;
}

double RmsShareOfOlderLight(double sun_gone_on_rad) {
  constexpr double kADegree = 0.005;
  return std::clamp(kADegree * DegFromRad(sun_gone_on_rad),
                    RmsShareOf(Effect::kCurrentLight),
                    RmsShareOf(Effect::kProbeShading));
}

}  // namespace pleinair
