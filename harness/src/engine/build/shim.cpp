// The whole interface between the harness and one Verilated model: plain C functions on one instance.
// The generated file before this one defines HV_SIGNALS(X), one X(member) for each port and public variable. What a
// member is, its C++ type says, in every version of Verilator. HV_FORCED(X) has one X(place in that table, member) for
// each that can be forced, HV_INOUTS(X) the same for each `inout` that the bench may drive.
// Events ($finish, $error, printed text) are collected in the instance and fetched after eval: no calls back.
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "verilated.h"
#if VM_TRACE_FST
#include "verilated_fst_c.h"
using HvTrace = VerilatedFstC;
#elif VM_TRACE
#include "verilated_vcd_c.h"
using HvTrace = VerilatedVcdC;
#endif
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

#define HV_API extern "C" __attribute__((visibility("default")))

namespace {

enum HvEventKind : uint32_t { HV_FINISH = 0, HV_STOP = 1, HV_FATAL = 2, HV_WARNING = 3 };

struct HvEvent {
    uint32_t kind;
    uint32_t line;
    std::string file;
    std::string message;
};

enum HvKind : uint32_t { HV_BITS = 0, HV_REAL = 1, HV_TEXT = 2, HV_OTHER = 3 };

constexpr uint32_t HV_DIMENSIONS = 8;

struct HvSignal {
    void* data;    // what is read
    void* target;  // what is written: the same, except of a signal that can be forced, and of an `inout`
    void* force_enable;  // the bits forced, and their values; null if it cannot be forced
    void* force_value;
    uint32_t kind;
    uint32_t element_bytes;
    uint32_t dimensions;
    uint32_t extents[HV_DIMENSIONS];  // of the unpacked dimensions, outermost first
};

template <typename T> struct HvShape {
    static void fill(HvSignal& out) {
        const bool number = std::is_same<T, CData>::value || std::is_same<T, SData>::value
            || std::is_same<T, IData>::value || std::is_same<T, QData>::value;
        out.kind = number ? HV_BITS : std::is_same<T, double>::value ? HV_REAL
            : std::is_same<T, std::string>::value ? HV_TEXT : HV_OTHER;
        out.element_bytes = sizeof(T);
    }
};
template <std::size_t N> struct HvShape<VlWide<N>> {
    static void fill(HvSignal& out) {
        out.kind = HV_BITS;
        out.element_bytes = sizeof(VlWide<N>);
    }
};
template <typename T, std::size_t N> struct HvArray {
    static void fill(HvSignal& out) {
        if (out.dimensions < HV_DIMENSIONS) out.extents[out.dimensions] = static_cast<uint32_t>(N);
        out.dimensions += 1;
        HvShape<T>::fill(out);
        // An array of another layout than rows of elements is none that the harness knows.
        if (out.dimensions > HV_DIMENSIONS || sizeof(T) % out.element_bytes != 0) out.kind = HV_OTHER;
    }
};
template <typename T, std::size_t N> struct HvShape<VlUnpacked<T, N>> : HvArray<T, N> {
    static_assert(sizeof(VlUnpacked<T, N>) == N * sizeof(T), "an array is its elements");
};
template <typename T, std::size_t N> struct HvShape<T[N]> : HvArray<T, N> {};

template <typename T> HvSignal signal_of(T& member) {
    HvSignal found{};
    found.data = found.target = (void*)&member;
    HvShape<typename std::remove_cv<T>::type>::fill(found);
    return found;
}

struct HvFatal final : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// The width of a row of bits, rounded up: 8 bytes hold any vector of at most 64 bits.
using HvBits = std::vector<uint64_t>;
HvBits bits_of(std::size_t bytes) { return HvBits((bytes + 7) / 8); }

// A signal that can be forced. Verilator keeps what the design assigns in the member; readers in the design get, bit by
// bit, value where enable is 1. The bench reads the same from `shown`.
struct HvForced {
    std::size_t bytes;
    const void* member;
    void* enable;
    void* value;
    HvBits shown, asked_enable, asked_value, put_enable, put_value;

    void before() {
        if (asked_enable == put_enable && asked_value == put_value) return;
        std::memcpy(enable, asked_enable.data(), bytes);
        std::memcpy(value, asked_value.data(), bytes);
        put_enable = asked_enable;
        put_value = asked_value;
    }
    void after() {
        std::memcpy(shown.data(), member, bytes);
        for (std::size_t at = 0; at < shown.size(); ++at)
            shown[at] = (shown[at] & ~asked_enable[at]) | (asked_value[at] & asked_enable[at]);
    }
};

// An `inout`, which Verilator splits into what comes in and what goes out with an enable for each bit. What comes in is
// what goes out where the design drives, else what the bench drives.
struct HvInout {
    // Puts what comes in; whether it has changed.
    bool (*resolve)(HvInout&);
    void* in;
    const void* out;
    const void* enable;
    HvBits driven;
};

// The size is known here, so that nothing is called to copy and compare: a bus has forty of these, and each is looked at
// twice in an evaluation.
template <std::size_t BYTES> bool resolve_inout(HvInout& self) {
    constexpr std::size_t WORDS = (BYTES + 7) / 8;
    uint64_t in[WORDS] = {}, out[WORDS] = {}, enable[WORDS] = {};
    std::memcpy(in, self.in, BYTES);
    std::memcpy(out, self.out, BYTES);
    std::memcpy(enable, self.enable, BYTES);
    bool changed = false;
    for (std::size_t at = 0; at < WORDS; ++at) {
        const uint64_t now = (out[at] & enable[at]) | (self.driven[at] & ~enable[at]);
        changed |= now != in[at];
        in[at] = now;
    }
    if (changed) std::memcpy(self.in, in, BYTES);
    return changed;
}

struct HvInstance;

struct HvContext final : VerilatedContext {
    HvInstance* owner = nullptr;
};

struct HvInstance {
    HvContext context;
    HV_MODEL* model = nullptr;
    std::vector<HvSignal> signals;
    std::vector<HvForced> forced;
    std::vector<HvInout> inouts;
    std::vector<HvEvent> events;
    std::string text;
    std::string taken;  // keeps the text handed out alive until the next call
    HvEvent event{};
    uint8_t pending = 0;  // bit 0: text or events to be fetched; bit 1: the model may not be evaluated again
    bool recording = false;  // the runtime is writing a wave file
#if VM_TRACE
    HvTrace* trace = nullptr;
#endif
};

HvInstance* owner() {
    auto* const context = static_cast<HvContext*>(Verilated::threadContextp());
    return context ? context->owner : nullptr;
}

void record(uint32_t kind, const char* file, int line, const char* message) {
    if (HvInstance* const self = owner()) {
        self->events.push_back(HvEvent{kind, static_cast<uint32_t>(line > 0 ? line : 0), file ? file : "", message ? message : ""});
        self->pending |= 1;
    }
}

template <typename T> void add_forced(HvInstance* self, std::size_t at, T& member, T& enable, T& value) {
    const HvBits none = bits_of(sizeof(T));
    self->forced.push_back(HvForced{sizeof(T), (void*)&member, (void*)&enable, (void*)&value, none, none, none, none, none});
    auto& signal = self->signals[at];
    auto& forced = self->forced.back();
    std::memcpy(forced.shown.data(), (void*)&member, sizeof(T));
    signal.data = forced.shown.data();
    signal.force_enable = forced.asked_enable.data();
    signal.force_value = forced.asked_value.data();
}
// A type for which Verilator keeps the enable in another way.
template <typename T, typename E, typename V> void add_forced(HvInstance*, std::size_t, T&, E&, V&) {}

template <typename T> void add_inout(HvInstance* self, std::size_t at, T& in, T& out, T& enable) {
    self->inouts.push_back(
        HvInout{resolve_inout<sizeof(T)>, (void*)&in, (void*)&out, (void*)&enable, bits_of(sizeof(T))});
    self->signals[at].target = self->inouts.back().driven.data();
}

inline void evaluate(HvInstance* self) {
#if HV_DIRECT_EVAL
    // Past the first time, `eval_step` adds only the ends of threads that this model does not have: half its time
    // on a small design goes to thread-local variables. Defined only where the generated text is known.
    auto* const root = self->model->rootp;
    if (VL_LIKELY(root->vlSymsp->__Vm_didInit)) {
        Vdut___024root___eval(root);
        return;
    }
#endif
    self->model->eval();
}

#if HV_OVERRIDES
void evaluate_overridden(HvInstance* self) {
    for (auto& forced : self->forced) forced.before();
    for (auto& inout : self->inouts) inout.resolve(inout);
    evaluate(self);
    // What the design drives now may come in again through an `inout`.
    for (int round = 0;; ++round) {
        bool changed = false;
        for (auto& inout : self->inouts) changed |= inout.resolve(inout);
        if (!changed) break;
        if (round == 100) throw std::runtime_error("its `inout`s do not settle");
        evaluate(self);
    }
    for (auto& forced : self->forced) forced.after();
}
#endif

}  // namespace

// ---- what the runtime calls (VL_PRINTF is defined to this)

int hv_printf(const char* format, ...) {
    char small[512];
    va_list arguments;
    va_start(arguments, format);
    va_list again;
    va_copy(again, arguments);
    const int length = vsnprintf(small, sizeof small, format, arguments);
    va_end(arguments);
    if (length > 0) {
        if (HvInstance* const self = owner()) {
            if (static_cast<size_t>(length) < sizeof small) {
                self->text.append(small, static_cast<size_t>(length));
            } else {
                const size_t before = self->text.size();
                self->text.resize(before + static_cast<size_t>(length) + 1);
                vsnprintf(&self->text[before], static_cast<size_t>(length) + 1, format, again);
                self->text.resize(before + static_cast<size_t>(length));
            }
            self->pending |= 1;
        }
    }
    va_end(again);
    return length;
}

void vl_finish(const char* file, int line, const char*) VL_MT_UNSAFE {
    record(HV_FINISH, file, line, "$finish");
    Verilated::threadContextp()->gotFinish(true);
}

void vl_stop(const char* file, int line, const char*) VL_MT_UNSAFE { record(HV_STOP, file, line, "$stop"); }

void vl_fatal(const char* file, int line, const char*, const char* message) VL_MT_UNSAFE {
    record(HV_FATAL, file, line, message);
    // A file that cannot be written: the runtime closes it after this call and goes on. Nothing above would catch.
    if (HvInstance* const self = owner()) {
        if (self->recording) return;
    }
    throw HvFatal(message ? message : "fatal");
}

void vl_warn(const char* file, int line, const char*, const char* message) VL_MT_UNSAFE {
    record(HV_WARNING, file, line, message);
}

// ---- what the harness calls

HV_API uint32_t hv_interface() { return HV_INTERFACE; }

HV_API void hv_bind(HvInstance* self) { Verilated::threadContextp(&self->context); }

HV_API HvInstance* hv_new(uint64_t seed, int32_t random_reset, int32_t argc, const char** argv) {
    HvInstance* const self = new HvInstance;
    self->context.owner = self;
    hv_bind(self);
    self->context.threads(1);
    self->context.randReset(random_reset);
    self->context.randSeed(static_cast<int>(seed & 0x7fffffff));
    self->context.errorLimit(1);
    self->context.fatalOnError(false);
#if VM_TRACE
    self->context.traceEverOn(true);
#endif
    if (argc > 0) self->context.commandArgs(argc, argv);
    try {
        self->model = new HV_MODEL{&self->context, "TOP"};
    } catch (const std::exception&) {
        self->model = nullptr;
        self->pending |= 2;
        return self;
    }
    auto& symbols = *self->model->rootp->vlSymsp;
#define HV_ADD(member) self->signals.push_back(signal_of(symbols.member));
    HV_SIGNALS(HV_ADD)
#undef HV_ADD
#define HV_ADD(at, member) add_forced(self, at, symbols.member, symbols.member##__VforceEn, symbols.member##__VforceVal);
    HV_FORCED(HV_ADD)
#undef HV_ADD
#define HV_ADD(at, member) add_inout(self, at, symbols.member, symbols.member##__out, symbols.member##__en);
    HV_INOUTS(HV_ADD)
#undef HV_ADD
    (void)symbols;
    return self;
}

HV_API void hv_delete(HvInstance* self) {
    hv_bind(self);
    try {
        self->recording = true;
#if VM_TRACE
        if (self->trace) {
            self->trace->close();
            delete self->trace;
        }
#endif
        delete self->model;
    } catch (...) {
        // Messages can no longer be taken: the instance is being deleted.
    }
    // The thread must not keep a pointer to a context that is gone.
    Verilated::threadContextp(nullptr);
    delete self;
}

HV_API void hv_eval_bound(HvInstance* self) {
    try {
#if HV_OVERRIDES
        evaluate_overridden(self);
#else
        evaluate(self);
#endif
    } catch (const HvFatal&) {
        self->pending |= 3;
    } catch (const std::exception& error) {
        record(HV_FATAL, "", 0, error.what());
        self->pending |= 3;
    }
}

HV_API void hv_final(HvInstance* self) {
    hv_bind(self);
    try {
        self->model->final();
    } catch (const std::exception&) {
        self->pending |= 3;
    }
}

HV_API void hv_time(HvInstance* self, uint64_t time) { self->context.time(time); }
HV_API int32_t hv_precision(HvInstance* self) { return self->context.timeprecision(); }
HV_API uint8_t* hv_pending(HvInstance* self) { return &self->pending; }

HV_API uint32_t hv_signals(HvInstance* self, const HvSignal** signals) {
    *signals = self->signals.data();
    return static_cast<uint32_t>(self->signals.size());
}

HV_API const char* hv_text_get(const void* text, uint64_t* length) {
    auto& value = *static_cast<const std::string*>(text);
    *length = value.size();
    return value.data();
}

HV_API void hv_text_set(void* text, const char* value, uint64_t length) {
    static_cast<std::string*>(text)->assign(value, length);
}

HV_API const char* hv_take_text(HvInstance* self, uint64_t* length) {
    self->taken.swap(self->text);
    self->text.clear();
    *length = self->taken.size();
    return self->taken.data();
}

// 1 while there was an event; clears the "to be fetched" bit when there is none left.
HV_API int32_t hv_take_event(HvInstance* self, uint32_t* kind, uint32_t* line, const char** file, const char** message) {
    if (self->events.empty()) {
        self->pending &= static_cast<uint8_t>(~1u);
        return 0;
    }
    self->event = self->events.front();
    self->events.erase(self->events.begin());
    *kind = self->event.kind;
    *line = self->event.line;
    *file = self->event.file.c_str();
    *message = self->event.message.c_str();
    return 1;
}

HV_API int32_t hv_trace_open(HvInstance* self, const char* path, int32_t level, const char* scope) {
#if VM_TRACE
    hv_bind(self);
    try {
        if (!self->trace) {
            self->trace = new HvTrace;
            if (scope && *scope) self->trace->dumpvars(level, scope);
            self->model->trace(self->trace, level > 0 ? level : 99);
        }
        self->trace->open(path);
        return self->trace->isOpen() ? 1 : -1;
    } catch (const std::exception&) {
        return -1;
    }
#else
    (void)self;
    (void)path;
    (void)level;
    (void)scope;
    return 0;
#endif
}

HV_API void hv_trace_dump(HvInstance* self, uint64_t time) {
#if VM_TRACE
    if (self->trace && self->trace->isOpen()) {
        hv_bind(self);
        self->recording = true;
        self->trace->dump(time);
        self->recording = false;
    }
#else
    (void)self;
    (void)time;
#endif
}

HV_API void hv_trace_flush(HvInstance* self) {
#if VM_TRACE
    if (self->trace && self->trace->isOpen()) {
        hv_bind(self);
        self->recording = true;
        self->trace->flush();
        self->recording = false;
    }
#else
    (void)self;
#endif
}

HV_API void hv_trace_close(HvInstance* self) {
#if VM_TRACE
    if (self->trace) {
        hv_bind(self);
        self->recording = true;
        self->trace->close();
        self->recording = false;
    }
#else
    (void)self;
#endif
}

HV_API int32_t hv_coverage_write(HvInstance* self, const char* path) {
#if VM_COVERAGE
    hv_bind(self);
    self->context.coveragep()->write(path);
    return 1;
#else
    (void)self;
    (void)path;
    return 0;
#endif
}
