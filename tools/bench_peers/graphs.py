"""ONNX Runtime and LiteRT: the same two graphs, written node by node. They infer; they do not learn."""

import golden
import numpy as np
from peers import Peer, single


class Built(Peer):
    """Subclasses give linear(), leaky(), columns(), joined(), repeated(), add(), subtract() of a graph."""

    kinds = ("graph", "decide")

    def chain(self, names, x):
        for name in names:
            x = self.leaky(self.linear(name, x))
        return x

    def from_latent(self, state, action):
        latent = self.chain(("share.0", "share.1", "share.2"), self.joined(state, action))
        short = self.chain(("strb.0", "strb.1"), latent)
        both = self.add(short, self.chain(("tdb.0", "tdb.1"), latent))
        now = self.linear("dec", short)
        return now, self.subtract(self.linear("dec", both), now)  # the decoder's bias cancels

    def build_graph(self, x):
        state = self.chain(("enc_s.0", "enc_s.1"), self.columns(x, 0, golden.SIGNALS))
        action = self.chain(("enc_a.0", "enc_a.1"), self.columns(x, golden.ROOMS, golden.INPUTS))
        return *self.from_latent(state, action), self.linear("dec", state)

    def build_decide(self, signals, setpoints):
        state = self.chain(("enc_s.0", "enc_s.1"), signals)
        known = self.repeated(self.columns(signals, golden.ROOMS, golden.SIGNALS))
        action = self.chain(("enc_a.0", "enc_a.1"), self.joined(known, setpoints))
        return self.from_latent(self.repeated(state), action)


class OnnxRuntime(Built):
    package, what = "onnxruntime", "CPU provider"

    def start(self):
        from onnx import helper, numpy_helper

        self.helper, self.numpy_helper = helper, numpy_helper

    def node(self, kind, given, **options):
        self.nodes.append(self.helper.make_node(kind, list(given), [f"v{len(self.nodes)}"], **options))
        return self.nodes[-1].output[0]

    def constant(self, values):
        name = f"c{len(self.values)}"
        self.values.append(self.numpy_helper.from_array(np.asarray(values), name))
        return name

    def linear(self, name, x):
        return self.node("Gemm", [x, f"{name}.w", f"{name}.b"], transB=1)

    def leaky(self, x):
        return self.node("LeakyRelu", [x], alpha=0.2)

    def columns(self, x, first, last):
        ends = [self.constant(np.array([n], np.int64)) for n in (first, last, 1)]
        return self.node("Slice", [x, *ends])

    def joined(self, *parts):
        return self.node("Concat", parts, axis=1)

    def repeated(self, x):
        return self.node("Tile", [x, self.constant(np.array([self.count, 1], np.int64))])

    def add(self, a, b):
        return self.node("Add", [a, b])

    def subtract(self, a, b):
        return self.node("Sub", [a, b])

    def session(self, count, given, build):
        import onnxruntime
        from onnx import TensorProto

        self.nodes, self.values, self.count = [], [], count
        for (name, _, _), (w, b) in zip(golden.LAYERS, self.weights):
            self.values += [self.numpy_helper.from_array(w, f"{name}.w"), self.numpy_helper.from_array(b, f"{name}.b")]
        outputs = build(*given)
        info = self.helper.make_tensor_value_info
        into = [info(name, TensorProto.FLOAT, list(x.shape)) for name, x in given.items()]
        out = [info(name, TensorProto.FLOAT, [count, golden.ROOMS]) for name in outputs]
        graph = self.helper.make_graph(self.nodes, "network", into, out, self.values)
        model = self.helper.make_model(graph, opset_imports=[self.helper.make_opsetid("", 17)])
        model.ir_version = 9
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
        return lambda: session.run(None, given)

    def graph(self, count):
        return self.session(count, {"x": self.inputs(count)}, self.build_graph)

    def decide(self, count):
        given = {"signals": self.state(), "setpoints": self.setpoints(count)}
        return self.session(count, given, self.build_decide)


class LiteRt(Built):
    package, what = "ai-edge-litert", "XNNPACK; tensors set and read"

    def start(self):
        from ai_edge_litert import schema_py_generated as schema

        self.schema = schema

    def tensor(self, shape, values=None):
        s = self.schema
        t = s.TensorT()
        t.shape, t.name, t.buffer = list(shape), f"t{len(self.subgraph.tensors)}", 0
        t.type = s.TensorType.INT32 if values is not None and values.dtype == np.int32 else s.TensorType.FLOAT32
        if values is not None:
            buffer = s.BufferT()
            buffer.data = np.frombuffer(np.ascontiguousarray(values).tobytes(), np.uint8)
            t.buffer = len(self.model.buffers)
            self.model.buffers.append(buffer)
        self.subgraph.tensors.append(t)
        return len(self.subgraph.tensors) - 1

    def whole(self, *values):
        return self.tensor((len(values),), np.array(values, np.int32))

    def node(self, kind, given, shape, **options):
        """kind: as the schema's options are called, such as FullyConnected."""
        s = self.schema
        code = getattr(s.BuiltinOperator, "".join("_" + c if c.isupper() else c for c in kind)[1:].upper())
        if code not in self.codes:
            entry = s.OperatorCodeT()
            entry.builtinCode = entry.deprecatedBuiltinCode = code
            entry.version = 1
            self.codes[code] = len(self.model.operatorCodes)
            self.model.operatorCodes.append(entry)
        op = s.OperatorT()
        op.opcodeIndex, op.inputs, op.outputs = self.codes[code], list(given), [self.tensor(shape)]
        op.builtinOptionsType = getattr(s.BuiltinOptions, f"{kind}Options")
        op.builtinOptions = getattr(s, f"{kind}OptionsT")()
        for name, value in options.items():
            setattr(op.builtinOptions, name, value)
        self.subgraph.operators.append(op)
        return op.outputs[0]

    def shape(self, x):
        return self.subgraph.tensors[x].shape

    def linear(self, name, x):
        w, b = self.placed[name]
        return self.node("FullyConnected", [x, w, b], (self.shape(x)[0], self.shape(w)[0]))

    def leaky(self, x):
        return self.node("LeakyRelu", [x], self.shape(x), alpha=0.2)

    def columns(self, x, first, last):
        rows = self.shape(x)[0]
        return self.node("Slice", [x, self.whole(0, first), self.whole(rows, last - first)], (rows, last - first))

    def joined(self, *parts):
        shape = (self.shape(parts[0])[0], sum(self.shape(part)[1] for part in parts))
        return self.node("Concatenation", parts, shape, axis=1)

    def repeated(self, x):
        return self.node("Tile", [x, self.whole(self.count, 1)], (self.count, self.shape(x)[1]))

    def add(self, a, b):
        return self.node("Add", [a, b], self.shape(a))

    def subtract(self, a, b):
        return self.node("Sub", [a, b], self.shape(a))

    def session(self, count, given, build):
        import flatbuffers
        from ai_edge_litert.interpreter import Interpreter

        s = self.schema
        self.count, self.codes, self.model, self.subgraph = count, {}, s.ModelT(), s.SubGraphT()
        self.model.version, self.model.subgraphs, self.model.buffers = 3, [self.subgraph], [s.BufferT()]
        self.model.operatorCodes, self.subgraph.tensors, self.subgraph.operators = [], [], []
        self.placed = {
            name: (self.tensor(w.shape, w), self.tensor(b.shape, b))
            for (name, _, _), (w, b) in zip(golden.LAYERS, self.weights)
        }
        self.subgraph.inputs = [self.tensor(x.shape) for x in given]
        self.subgraph.outputs = list(build(*self.subgraph.inputs))
        builder = flatbuffers.Builder(1 << 16)
        builder.Finish(self.model.Pack(builder), b"TFL3")
        interpreter = Interpreter(model_content=bytes(builder.Output()), num_threads=1)
        interpreter.allocate_tensors()
        into = [t["index"] for t in interpreter.get_input_details()]
        out = [t["index"] for t in interpreter.get_output_details()]

        def one():
            for index, values in zip(into, given):
                interpreter.set_tensor(index, values)
            interpreter.invoke()
            return [interpreter.get_tensor(index) for index in out]

        return one

    def graph(self, count):
        return self.session(count, [single(self.inputs(count))], self.build_graph)

    def decide(self, count):
        return self.session(count, [self.state(), self.setpoints(count)], self.build_decide)
