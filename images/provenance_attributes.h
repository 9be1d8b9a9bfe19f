// Provenance as attributes of an image file, named "plumbline:sceneHash" and so on.
#pragma once

#include <OpenImageIO/imageio.h>

#include "images/provenance.h"

namespace plumb {

// Adds the fields that are set, in their order.
void write_attributes(const Provenance& provenance, OIIO::ImageSpec& spec);

// Leaves out what is missing or is of another type.
Provenance read_attributes(const OIIO::ImageSpec& spec);

}  // namespace plumb
