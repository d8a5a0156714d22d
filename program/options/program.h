// SPDX-License-Identifier: MIT
//
// The executables of this project. They share commands and options: `stipple` has those for users,
// `stipple-lab` has them all, and makes named scenes.
#pragma once

#include "program/options/command.h"
#include "scene/scene.h"

#define SCENE_PREFIX "scene:"

/// An executable. Its main function passes a constant one to program_main.
typedef struct program {
    const char* name;               ///< name of the executable, and prefix of its messages
    const command* const* commands; ///< sorted by name; NULL at the end
    /// Whether options that only one table of one paper needs are accepted.
    bool is_lab;
    /// Adds the scene that an input "scene:NAME,..." names, as stp_build_desc.generate. NULL: named
    /// scenes are refused.
    stp_result (*make_scene)(stp_scene* scene, const char* input, void* user);
    const char* scenes_version; ///< changes when a named scene changes; NULL if there are none
} program;

/// Finds the command in the arguments, reads its options, and runs it. @return the exit code
int program_main(const program* self, int argc, char** argv);

/// The program that runs; before program_main, one without commands.
const program* program_get(void);

/// Whether an input names a scene rather than a file: it begins with SCENE_PREFIX.
bool program_is_scene(const char* input);

/// Makes a named scene by the running program's function. @return STP_ERROR_ARGUMENT (logged) if it
/// has none; else as program.make_scene
STP_MUST_USE stp_result program_make_scene(stp_scene* scene, const char* input, void* user);
