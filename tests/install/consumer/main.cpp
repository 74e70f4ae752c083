// A program outside the project that uses three of the libraries, and the bundled sequence.
#include <cstdio>

#include <pleinair/datasets/sequence.h>
#include <pleinair/pipeline/frame_pipeline.h>
#include <pleinair/sunmodel/sun_position.h>

int main() {
  const pleinair::Sequence courtyard = pleinair::ReadSequence(SAMPLE);
  const auto sun =
      pleinair::ComputeSunPosition(courtyard.site.value(), courtyard.frames.at(0).time);
  std::printf("%zu frames, sun %.3f above\n", courtyard.frames.size(), sun.ElevationRad());
  return sun.ElevationRad() > 0.0 && sizeof(pleinair::FramePipeline) > 0 ? 0 : 1;
}
