"""Translates PTX for `fake_cuda.sh` so that data races are told.

    watched_ptx.py TOOL MODULE.ptx MODULE.so

Threads of a real GPU run at the same time, those of `fake_cuda.sh` one after the other: its results cannot show that a
thread reads or overwrites what another one writes. Here every load and store of global memory is noted. A race is
where one thread changes a value which another one reads or changes too without a barrier between them, for threads of
two blocks within a launch. Stores of the value that stands there already, by which all threads store what they agree
on, are no change. Atomic operations are left out. Races go to the file TCONTACT_RACES, a line each.
"""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

SPACES = ("param", "local", "shared")  # memory that a thread or a block has for itself
MOST = 20  # lines of a kernel

WATCH = """
#include <unistd.h>
struct note { uint64_t at, launch; uint32_t writer, reader, write_turn, read_turn; uint16_t many, shared; };
static struct note *notes; static uint64_t launches; static uint32_t barriers; static int told;
static const char *running = "";
enum { NOTES = 1 << 20, NOBODY = 0xffffffffu };
static void tell_race(int line, const char *how, uint32_t one, uint32_t other) {
  const char *path = getenv("TCONTACT_RACES");
  if (told++ >= MOST || !path) return;
  FILE *f = fopen(path, "a"); if (!f) return;
  fprintf(f, "%s, %s line %d: thread %u %s what thread %u %s\\n", running, __FILE__, line, one, how, other,
          how[0] == 'r' ? "changed" : "read or changed");
  fclose(f);
}
static inline uint32_t whole(struct ctx *c) { return c->ctaid * c->ntid + c->tid; }
static struct note *note_of(uint64_t at) {
  if (!notes) notes = calloc(NOTES, sizeof *notes);
  struct note *n = &notes[(at * 0x9E3779B97F4A7C15ull) >> 44];
  if (n->at != at || n->launch != launches) {
    memset(n, 0, sizeof *n);
    n->at = at; n->launch = launches; n->writer = n->reader = NOBODY;
  }
  return n;
}
static inline int own(struct ctx *c, const void *p) {
  const char *frame = __builtin_frame_address(0);
  return (const char *)p > frame - (1 << 18) && (const char *)p < frame + (1 << 18);
}
static int at_once(struct ctx *c, uint32_t other, uint32_t turn) {
  return other != NOBODY && other != whole(c) && (other / c->ntid != c->ctaid || turn == barriers);
}
static void look(struct ctx *c, const char *p, int size, int line) {
  if (own(c, p)) return;
  for (int i = 0; i < size; i += 4) {
    struct note *n = note_of((uint64_t)(p + i) >> 2);
    if (!n->shared && at_once(c, n->writer, n->write_turn)) tell_race(line, "reads", whole(c), n->writer);
    if (n->reader != whole(c) && at_once(c, n->reader, n->read_turn)) n->many = 1;
    else if (n->read_turn != barriers) n->many = 0;
    n->reader = whole(c); n->read_turn = barriers;
  }
}
static void change(struct ctx *c, const char *p, const void *value, int size, int line) {
  if (own(c, p)) return;
  for (int i = 0; i < size; i += 4) {
    struct note *n = note_of((uint64_t)(p + i) >> 2);
    if (!memcmp(p + i, (const char *)value + i, size < 4 ? size : 4)) {
      if (at_once(c, n->writer, n->write_turn)) n->shared = 1;
      continue;
    }
    if (at_once(c, n->writer, n->write_turn)) tell_race(line, "changes", whole(c), n->writer);
    else if (at_once(c, n->reader, n->read_turn) || (n->many && n->read_turn == barriers))
      tell_race(line, "changes", whole(c), n->reader);
    n->writer = whole(c); n->write_turn = barriers; n->shared = 0;
  }
}
"""


def watching(ptx2c: ModuleType) -> None:
    """Let the translator put a note before every load and store of global memory."""
    head = ptx2c.HEAD.replace("static routine now;", WATCH.replace("MOST", str(MOST)) + "static routine now;", 1)
    head = head.replace(
        "  use_fibers = fibers && block > 1;",
        "  ++launches; told = 0; barriers = 0;\n  use_fibers = fibers && block > 1;",
        1,
    )
    going_on = "if (waiting == live) { for"
    assert going_on in head
    ptx2c.HEAD = head.replace(going_on, "if (waiting == live) { ++barriers; for", 1)
    plain = ptx2c.Statement.instruction

    def instruction(self, op, operands, text):
        done = plain(self, op, operands, text)
        if op[0] not in ("ld", "ldu", "st") or any(space in op for space in SPACES):
            return done
        kind, count = ptx2c.CTYPE[op[-1]], 2 if "v2" in op else 4 if "v4" in op else 1
        address = self.address(operands[0] if op[0] == "st" else operands[1])
        if op[0] != "st":
            return f"look(c, (char *){address}, {count} * sizeof({kind}), __LINE__); {done}"
        values = [part.strip() for part in operands[1].strip("{}").split(",")]
        listed = ", ".join(self.value(value, op[-1]) for value in values)
        return (
            f"{{ {kind} new_[] = {{ {listed} }}; change(c, (char *){address}, new_, sizeof new_, __LINE__); }} {done}"
        )

    ptx2c.Statement.instruction = instruction


def main(tool: str, source: str, target: str) -> int:
    """Translate a module."""
    spec = importlib.util.spec_from_file_location("ptx2c", tool)
    ptx2c = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(ptx2c)
    watching(ptx2c)
    code = Path(target).with_suffix(".c")
    text = ptx2c.Module(Path(source).read_text()).write()
    code.write_text(re.sub(r"void run_(\w+)\(.*?\) \{", r'\g<0> running = "\1";', text))
    options = ["-O1", "-w", "-fPIC", "-shared", "-fno-strict-aliasing", "-fwrapv", "-ffp-contract=off", "-mfma"]
    return subprocess.run(["gcc", *options, "-o", target, str(code), "-lm"], check=False).returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
