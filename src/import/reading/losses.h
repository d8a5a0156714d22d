// SPDX-License-Identifier: MIT
//
// Content of an input that a .stip does not keep: counted while the file is read, and reported in
// one warning at the end.
#pragma once

#include "base/core/context.h"

/// Each with its singular, plural and replacement.
#define STP_LOSSES(X)                                                                              \
    X(ANIMATION, "animation", "animations", "drawn in the stored pose")                            \
    X(SKIN, "skin", "skins", "drawn in the stored pose")                                           \
    X(MORPH, "morph target", "morph targets", "drawn at the stored weights")                       \
    X(LINE, "line element", "line elements", NULL)                                                 \
    X(CURVE, "curve or surface statement", "curve and surface statements", NULL)                   \
    X(CAMERA, "camera without perspective", "cameras without perspective", NULL)                   \
    X(POINT, "point without a finite position", "points without a finite position", NULL)          \
    X(UNFINISHED_LINE, "unfinished last line", "unfinished last lines", NULL)                      \
    X(TIME, "point time beyond 1e19", "point times beyond 1e19", "stored as 0")                    \
    X(COLUMN, "point column", "point columns", NULL)                                               \
    X(HEIGHT_MAP, "map of heights", "maps of heights", NULL)                                       \
    X(SCANNER_PICTURE, "scanner picture", "scanner pictures", NULL)                                \
    X(SCAN, "scan without positions", "scans without positions", NULL)                             \
    X(LIGHT, "light", "lights", NULL)                                                              \
    X(SCENE, "additional scene", "additional scenes", NULL)                                        \
    X(WAVEFORM, "point waveform", "point waveforms", NULL)

typedef enum stp_loss {
#define X(name, one, many, instead) STP_LOSS_##name,
    STP_LOSSES(X)
#undef X
        STP_LOSS_COUNT
} stp_loss;

enum { STP_LOSS_EXTENSIONS_SIZE = 512 };

/// All zero: nothing was lost.
typedef struct stp_losses {
    uint64_t counts[STP_LOSS_COUNT];
    char extensions[STP_LOSS_EXTENSIONS_SIZE]; ///< names, separated by ", "
    uint32_t unnamed_extensions;               ///< number of extensions that did not fit
} stp_losses;

void stp_losses_add(stp_losses* losses, stp_loss loss, uint64_t count);

/// Adds an unsupported extension. Spaces and characters other than printable
/// ASCII become "?".
void stp_losses_add_extension(stp_losses* losses, const char* name);

/// Logs one warning, "PATH: not kept: ...", if anything was lost.
void stp_losses_report(stp_context* context, const char* path, const stp_losses* losses);
