// SPDX-License-Identifier: MIT
// Pictures of a flight: numbered PNG files in a folder, or a film encoded by ffmpeg as a child
// process.
#pragma once

#include "program/options/command.h"

#include <stipple/image.h>

#include <sys/types.h>

typedef struct video {
    stp_context* context;
    const char* path;
    bool is_folder;
    bool made_folder;      ///< it was not there before
    uint32_t frame_count;  ///< number after the last frame that was written to the folder
    pid_t child;           ///< ffmpeg; 0: not running
    int pipe;              ///< write end of its standard input; -1: none
    char unfinished[4096]; ///< temporary output of the child, next to `path`
    uint8_t* row;
} video;

/// Whether an output is a folder: its name ends with a slash, or it exists as one.
bool video_is_folder(const char* path);

/// Creates the folder, or starts ffmpeg for a film that replaces `path` when complete. @return
/// false with the message printed
bool video_open(stp_context* context, const char* path, uint32_t width, uint32_t height, double fps,
                video* v);

/// A flight_sink; the video is `user`. Transparency is composited on black in a film, and kept in
/// PNG files.
stp_result video_add(void* user, const stp_image* image, uint32_t frame);

/// Finishes. @return false with the message printed; removes a film that is not `whole`, and
/// pictures of frames if the flight was interrupted
bool video_close(video* v, bool whole);
