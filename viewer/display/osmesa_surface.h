#pragma once

#include <memory>

#include "viewer/display/surface.h"

namespace relume {

/// A software framebuffer in memory; needs no display. Mesa's library is loaded when the first one
/// is made, so that commands that draw nothing do not pay for it.
class OsmesaSurface final : public Surface {
 public:
  /// Throws Error(output) when the library or the context is missing.
  explicit OsmesaSurface(ivec2 size_px);
  ~OsmesaSurface() override;

  GlLoader loader() const override;
  ivec2 size_px() const override;
  void resize(ivec2 size_px) override;
  void renew_context() override;
  /// Waits until everything is drawn: what drawing needs is kept until then.
  void present() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace relume
