// Prepares a scene, moves its first light and writes both pictures; then does the same from the
// cache's file. Usage: relight FOLDER

#include <relume/relume.h>

#include <cstdio>

int main(int argc, char** argv) try {
  const std::string folder = argc > 1 ? argv[1] : ".";
  relume::api::PrepareSettings settings;
  settings.records = 4;
  settings.width = 96;
  settings.height = 72;
  const auto cache = relume::api::Cache::prepare("spheres", settings);
  cache.save(folder + "/spheres.relume");

  std::vector<relume::api::Light> lights = cache.lights();
  relume::api::Relighter relighter(cache);
  relighter.relight(lights);
  relighter.save(folder + "/before.exr");

  lights.front().position[1] *= 1.5f;
  relighter.relight(lights);
  relighter.save(folder + "/after.exr");

  const auto before = relume::api::read_image(folder + "/before.exr");
  const auto moved = relume::api::compare(relighter.frame(), before.view());
  std::printf("relume %s: %d x %d pixels, %llu records; the move changed %g\n",
              relume::api::version().c_str(), cache.width(), cache.height(),
              static_cast<unsigned long long>(cache.record_count()), moved.error_image);

  relume::api::Relighter again(relume::api::Cache::open(folder + "/spheres.relume"));
  again.relight(lights);
  const double difference = relume::api::compare(again.frame(), relighter.frame()).max_error;
  return moved.error_image > 0 && difference == 0 ? 0 : 1;
} catch (const relume::api::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return static_cast<int>(error.kind());
}
