// Composites of pictures that the caller has, at the place of a sequence: here from files, in a
// program from wherever its camera gives them.
//
//   own_pictures SEQUENCE FOLDER START PICTURE...      START as 2005-06-21T09:50:00Z
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>

#include <pleinair/scene/image_io.h>
#include <pleinair/session/sequence_session.h>
#include <pleinair/sunmodel/time_text.h>

int main(int argc, char** argv) try {
  if (argc < 5) {
    throw std::runtime_error("expected a sequence, a folder, a time and 8-bit pictures");
  }
  const std::filesystem::path folder = argv[2];
  std::filesystem::create_directories(folder);

  // Mesh, survey, camera and virtual objects are the sequence's; its frames are not read.
  pleinair::SequenceSession session({.sequence = argv[1]});
  for (const std::string& note : session.TakeNotes()) std::cerr << note << '\n';

  auto time = pleinair::ParseUtcTime(argv[3]);
  for (int i = 4; i < argc; ++i, time += std::chrono::seconds(1)) {
    pleinair::CapturedPicture captured;
    captured.picture = pleinair::ReadDisplayImage(argv[i]);
    captured.time = time;  // Its camera is the sequence's, its exposure is not known.
    const auto step = session.Process(std::move(captured));
    if (!step.result) {
      std::cerr << argv[i] << ": " << step.result.error().reason << '\n';
      continue;
    }
    const auto& light = step.result->estimate.lighting;
    std::printf("%s: sun %.3g, sky %.3g (green)\n",
                argv[i],
                light.sun.irradiance_rgb.g,
                light.SkyIrradianceRgb().g);
    pleinair::WritePng(folder / (std::to_string(step.frame->index) + ".png"), session.Show(step));
  }
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
