// SPDX-License-Identifier: MIT
// Point attributes: everything is in stipple/attributes.h.
#pragma once

#include <stipple/attributes.h>
