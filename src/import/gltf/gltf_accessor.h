// SPDX-License-Identifier: MIT
// Accessors (3.6.2): typed elements in buffer views, with sparse substitution.
#pragma once

#include "import/gltf/gltf.h"

typedef enum stp_gltf_component {
    STP_GLTF_I8 = 5120,
    STP_GLTF_U8 = 5121,
    STP_GLTF_I16 = 5122,
    STP_GLTF_U16 = 5123,
    STP_GLTF_U32 = 5125,
    STP_GLTF_F32 = 5126,
} stp_gltf_component;

typedef struct stp_gltf_accessor {
    uint32_t index;
    const unsigned char* bytes; ///< element 0; NULL: all elements are zero
    size_t stride, count;
    stp_gltf_component component;
    uint32_t component_count; ///< 1 to 4, 9 or 16
    bool normalized;
    size_t sparse_count; ///< elements replaced
    stp_gltf_component sparse_component;
    const unsigned char* sparse_indices; ///< each below count (checked); any order
    const unsigned char* sparse_values;  ///< packed
} stp_gltf_accessor;

/// Selects elements: `count` from `first` on, or those listed in `map`.
typedef struct stp_gltf_selection {
    size_t first, count;
    uint32_t* map; ///< NULL: a run
} stp_gltf_selection;

/// Reads the description of an accessor without locating its data; bytes stays NULL.
STP_MUST_USE stp_result stp_gltf_accessor_describe(stp_gltf_scope* scope, uint32_t index,
                                                   stp_gltf_accessor* accessor);

/// Reads and checks an accessor: all its elements are in memory.
STP_MUST_USE stp_result stp_gltf_accessor_get(stp_gltf_scope* scope, uint32_t index,
                                              stp_gltf_accessor* accessor);

/// Converts the selected elements, which must exist, to floats: component_count of each. Normalised
/// integers become -1..1 or 0..1 (3.6.2.2).
STP_MUST_USE stp_result stp_gltf_accessor_floats(stp_gltf_scope* scope,
                                                 const stp_gltf_accessor* accessor,
                                                 const stp_gltf_selection* selection, float* out);

/// The divisor of normalised integers of the accessor's type; else 1.
float stp_gltf_accessor_divisor(const stp_gltf_accessor* accessor);

/// All elements as unsigned numbers; the accessor must be of unsigned scalars.
STP_MUST_USE stp_result stp_gltf_accessor_indices(stp_gltf_scope* scope,
                                                  const stp_gltf_accessor* accessor, uint32_t* out);
