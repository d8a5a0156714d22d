// SPDX-License-Identifier: MIT
//
// A subcommand is one file: a table of options, and a function. --help, man pages and completions
// come from the same tables. Every command also has the options of options_common.
#pragma once

#include "base/core/context.h"

#include <jansson.h>

typedef enum option_type {
    OPTION_FLAG,   ///< bool*
    OPTION_TEXT,   ///< const char**
    OPTION_COUNT,  ///< uint64_t*: a whole number
    OPTION_WHOLE,  ///< uint32_t*: a whole number
    OPTION_NUMBER, ///< double*
    OPTION_FLOAT,  ///< float*: the number times `scale`
    OPTION_SIZE,   ///< uint64_t*: bytes, with K M G T (powers of 1024)
    OPTION_CHOICE, ///< int*: index of a word in `words`
    OPTION_SWITCH, ///< bool*: whether it is the second of two `words`
    OPTION_PIXELS, ///< uint32_t[2]: WxH
    OPTION_VECTOR, ///< double[3]: X,Y,Z; with `words`, a direction, also an axis: x, -x, y, ...
    OPTION_COLOR,  ///< uint8_t[3], sRGB: a CSS name, RRGGBB or RGB with or without #
    OPTION_TEXTS,  ///< option_texts: given again, it is one more
    OPTION_PARTIAL_FILE, ///< option_partial_file: a size as OPTION_SIZE, or a percentage as 5%
} option_type;

/// The beginning of a file: a number of bytes, or a part of it. Both 0: not given.
typedef struct option_partial_file {
    uint64_t bytes;
    double percent; ///< above 0, at most 100; 0: see `bytes`
} option_partial_file;

enum { OPTION_TEXTS_MAX = 256 };
typedef struct option_texts {
    const char* texts[OPTION_TEXTS_MAX];
    uint32_t count;
} option_texts;

typedef struct option {
    const char* name; ///< without dashes
    char letter;      ///< 0: none
    option_type type;
    const char* argument; ///< as help shows it, "PX"; NULL for flags
    /// Choices separated by |. Of a number, size or picture size: words that stand for 0, and the
    /// range allowed, as in "auto|1..1024"; NULL: any (a picture: 1..32768). A range may have no
    /// end: "1..".
    const char* words;
    const char* help; ///< one line
    /// Default if the option is given without a value; NULL: a value is required
    const char* fallback;
    void* value;
    bool* given;  ///< set if the option is given; may be NULL
    double scale; ///< of OPTION_FLOAT; 0: 1
    /// Heading under which help lists it; NULL: that of the option before it. Options with the same
    /// heading are listed together.
    const char* group;
    bool rare; ///< --help leaves it out; --help-all, man pages and completions list it
    /// Only one table of one paper needs it: only programs with is_lab have it. Also rare.
    bool lab_only;
} option;

enum { OPTION_TABLE_ROOM = 104 }; ///< most entries of a command's table, with the last one

// Options shared by several commands; `where` points to the value.
#define OPTION_THREADS(where)                                                                      \
    {                                                                                              \
        .name = "threads", .type = OPTION_COUNT, .argument = "N", .words = "auto|0..1024",         \
        .help = "number of threads; default all processors", .value = (where), .rare = true        \
    }
/// A memory limit: 0, or enough for a few threads to start.
#define OPTION_MEMORY_WORDS "auto|0|65536.."
#define OPTION_MEMORY(where)                                                                       \
    {                                                                                              \
        .name = "memory", .type = OPTION_SIZE, .argument = "SIZE", .words = OPTION_MEMORY_WORDS,   \
        .help = "memory limit, at least 64K, such as 8G or 512M; default no limit",                \
        .value = (where)                                                                           \
    }
/// The value is an int, an stp_gl_splats.
#define OPTION_GL_SPLATS(where)                                                                    \
    {                                                                                              \
        .name = "gl-splats", .type = OPTION_CHOICE, .argument = "WAY",                             \
        .words = "auto|points|compute",                                                            \
        .help = "OpenGL splat renderer: points, or a compute shader; default auto, which "         \
                "measures both first",                                                             \
        .value = (where), .rare = true                                                             \
    }
/// The value is an int, for tool_progress_names.
#define OPTION_PROGRESS(where)                                                                     \
    {                                                                                              \
        .name = "progress", .type = OPTION_CHOICE, .words = "auto|bar|json|none",                  \
        .help = "progress on stderr; default a bar if that is a terminal", .value = (where),       \
        .rare = true                                                                               \
    }
/// The columns of text files of points; checked by tool_take_columns.
#define OPTION_COLUMNS(place)                                                                      \
    {                                                                                              \
        .name = "columns", .type = OPTION_TEXT, .argument = "NAME,...",                            \
        .help = "meaning of the columns of a text file of points (XYZ, TXT, CSV, ASC, PTS): x, "   \
                "y, z, r, g, b, intensity, nx, ny, nz, class, or - to skip one; by default "       \
                "detected from the header, number and values of the columns",                      \
        .value = (place), .group = "Input", .rare = true                                           \
    }
/// Normals for meshes that have none; taken by tool_take_smooth.
#define OPTION_SMOOTH(place)                                                                       \
    {                                                                                              \
        .name = "smooth", .type = OPTION_NUMBER, .argument = "ANGLE", .words = "0..180",           \
        .help = "give meshes without normals smooth ones, across edges where faces turn by at "    \
                "most ANGLE degrees, such as 30 for CAD; default 0: faces look flat",              \
        .value = (place), .group = "Input", .rare = true                                           \
    }
#define OPTION_JSON(where)                                                                         \
    {                                                                                              \
        .name = "json", .help = "print one JSON object", .value = (where)                          \
    }
extern const char* const tool_progress_names[];

typedef struct command {
    const char* name;
    const char* arguments; ///< "INPUT... -o FILE.stip"
    const char* summary;   ///< one line, as `stipple help` lists it
    const char* text;      ///< paragraphs for `stipple help NAME` and the man page
    const char* examples;  ///< "$ command" lines, each after a line that describes it
    /// "PATH<tab>description" lines: files that the command reads and writes
    const char* files;
    /// Message about results after an interrupt; NULL: nothing was written
    const char* interrupted;
    /// Fills the table of options (ends with a NULL name); each value points into the command's own
    /// storage.
    const option* (*options)(void);
    /// Runs with the remaining arguments in order (argv[0] is the first; "-" is a file name);
    /// returns the exit code: 0, 1 (message printed) or 2.
    int (*run)(int argc, char** argv);
} command;

/// All commands of the running program, NULL at the end.
const command* const* commands(void);

/// A context that prints messages on stderr ("NAME: ..." of the program, notices only with
/// --verbose) and progress as requested: "auto" (also NULL: a bar if stderr is a terminal), "bar",
/// "json" (one object per line) or "none". The first interrupt stops the work at the next progress
/// report, a second one kills the process. NULL on failure: message printed.
stp_context* tool_context_create(uint32_t thread_count, uint64_t memory_limit_bytes,
                                 const char* progress);
/// Prints one sentence on stderr and returns 2, or 1.
int tool_usage_error(const char* format, ...) __attribute__((format(printf, 1, 2)));
int tool_error(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// Whether an interrupt (Ctrl+C) was received: for loops that report no progress.
bool tool_is_interrupted(void);
// Around work that may be retried: holds back errors that the library logs; at the end the last one
// is printed, continued by `more` (NULL: not), or dropped. One thread.
void tool_hold_errors(void);
/// The last error held; "" if there is none.
const char* tool_held_error(void);
void tool_release_errors(bool print, const char* more);
/// Prints the object and a newline on stdout and frees it; returns the exit code (1 if writing
/// fails).
int tool_print_json(json_t* object);
