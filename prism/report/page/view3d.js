// The 3D view: trajectory, ground truth, keyframes and point cloud. World has y down, so the
// camera of the view stands with its up along -y.
'use strict';

// Of the parts of a trajectory after the first (Okabe and Ito: told apart by colour-blind eyes).
const OTHER_PIECES = ['#009e73', '#cc79a7', '#e69f00', '#f0e442'];

function makeView3d(element, onKeyframe) {
  const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  element.appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(50, 1, 0.01, 1000);
  camera.up.set(0, -1, 0);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  controls.enableKeys = false;  // it would take the arrow keys from the whole page
  const objects = {};
  const positions = [];  // of the keyframes
  let frustumSize = 0.05;
  let selected = 0;

  function render() { renderer.render(scene, camera); }
  controls.addEventListener('change', render);

  function replace(name, object) {
    if (objects[name]) {
      object.visible = objects[name].visible;
      scene.remove(objects[name]);
      objects[name].geometry.dispose();
    }
    objects[name] = object;
    scene.add(object);
  }

  function geometryOf(values) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(values), 3));
    return geometry;
  }

  // Lines are seen through points.
  function onTop(object) {
    object.material.depthTest = false;
    object.renderOrder = 1;
    return object;
  }

  function lines(values, color, kind) {
    return onTop(new kind(geometryOf(values), new THREE.LineBasicMaterial({color: style(color)})));
  }

  // The pyramid of a keyframe's view, as line segments.
  function frustum(keyframe) {
    const q = new THREE.Quaternion(...keyframe.rotation);
    const t = new THREE.Vector3(...keyframe.position);
    const s = frustumSize;
    const corner = (x, y) => new THREE.Vector3(x * s, y * s, 1.4 * s).applyQuaternion(q).add(t);
    const c = [corner(-1, -0.75), corner(1, -0.75), corner(1, 0.75), corner(-1, 0.75)];
    const values = [];
    for (let i = 0; i < 4; ++i) {
      values.push(...t.toArray(), ...c[i].toArray());
      values.push(...c[i].toArray(), ...c[(i + 1) % 4].toArray());
    }
    return values;
  }

  function setBackground() { scene.background = new THREE.Color(style('--ground')); }

  const view = {
    // `pieces`: of each position the part of the map it belongs to; parts that are not known relative
    // to each other are not connected and have a colour each. Undefined: there is one.
    setTrajectory(values, pieces) {
      if (!pieces) {
        replace('trajectory', lines(values, '--estimate', THREE.Line));
        return;
      }
      const names = [...new Set(pieces)];
      const points = [], colors = [];
      for (let i = 1; i < pieces.length; ++i) {
        if (pieces[i] !== pieces[i - 1]) continue;
        const rank = names.indexOf(pieces[i]) % (OTHER_PIECES.length + 1);
        const color = new THREE.Color(rank === 0 ? style('--estimate') : OTHER_PIECES[rank - 1]);
        points.push(...values.slice(3 * i - 3, 3 * i + 3));
        colors.push(...color.toArray(), ...color.toArray());
      }
      const geometry = geometryOf(points);
      geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(colors), 3));
      replace('trajectory', onTop(new THREE.LineSegments(
          geometry, new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors}))));
    },
    setGroundtruth(values) { replace('groundtruth', lines(values, '--truth', THREE.Line)); },

    setCloud(xyz, intensities) {
      const geometry = geometryOf(xyz);
      const colors = new Float32Array(xyz.length);
      for (let i = 0; i < xyz.length; ++i) {
        colors[i] = 0.15 + 0.7 * intensities[Math.floor(i / 3)] / 255;
      }
      geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
      const material = new THREE.PointsMaterial(
          {size: 1.7, sizeAttenuation: false, vertexColors: THREE.VertexColors});
      replace('cloud', new THREE.Points(geometry, material));
    },

    setKeyframes(keyframes) {
      positions.length = 0;
      const values = [];
      for (const keyframe of keyframes) {
        positions.push(new THREE.Vector3(...keyframe.position));
        for (const value of frustum(keyframe)) values.push(value);
      }
      replace('keyframes', lines(values, '--keyframe', THREE.LineSegments));
    },

    select(index, keyframe) {
      selected = index;
      replace('selection', lines(frustum(keyframe), '--ink', THREE.LineSegments));
      render();
    },

    // The place of the frame that is looked at; null: it has none.
    setCursor(position) {
      replace('cursor', onTop(new THREE.Points(
          geometryOf(position || []), new THREE.PointsMaterial(
              {size: 9, sizeAttenuation: false, color: style('--bad')}))));
      objects.cursor.visible = position !== null;
      render();
    },

    setVisible(name, visible) {
      if (objects[name]) objects[name].visible = visible;
      render();
    },

    // Looks at trajectory and points from behind and above, all of them in view.
    reset() {
      const values = name => objects[name] ? objects[name].geometry.attributes.position.array : [];
      const all = boundsOf([...values('trajectory'), ...values('groundtruth')], values('cloud'));
      const box = new THREE.Box3(new THREE.Vector3(...all.low), new THREE.Vector3(...all.high));
      const size = Math.max(box.getSize(new THREE.Vector3()).length(), 0.1);
      box.getCenter(controls.target);
      // The sphere around the box touches the narrower side of the view.
      const half = Math.atan(Math.tan(camera.fov * Math.PI / 360) * Math.min(camera.aspect, 1));
      camera.position.copy(controls.target).add(new THREE.Vector3(0.25, -0.6, -1).normalize()
          .multiplyScalar(0.5 * size / Math.sin(half)));
      camera.near = 0.001 * size;
      camera.far = 1000 * size;
      camera.updateProjectionMatrix();
      controls.update();
      render();
    },

    // The size of a keyframe's pyramid goes with that of the trajectory.
    setExtent(metres) { frustumSize = Math.max(0.01, 0.025 * metres); },

    // Pixels of the view at which a keyframe stands.
    screenPosition(index) {
      camera.updateMatrixWorld();
      const p = positions[index].clone().project(camera);
      const size = renderer.getSize(new THREE.Vector2());
      return {x: (p.x + 1) / 2 * size.x, y: (1 - p.y) / 2 * size.y, inFront: p.z < 1};
    },
    render,
  };

  function resize() {
    const width = element.clientWidth, height = element.clientHeight;
    if (width === 0 || height === 0) return;
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    render();
  }
  new ResizeObserver(resize).observe(element);
  setBackground();
  resize();

  // A click without a drag takes the keyframe nearest to it, up to a finger's width away.
  let down = null;
  renderer.domElement.addEventListener('pointerdown', event => {
    down = {x: event.clientX, y: event.clientY};
  });
  renderer.domElement.addEventListener('pointerup', event => {
    if (!down || Math.hypot(event.clientX - down.x, event.clientY - down.y) > 5) return;
    const box = renderer.domElement.getBoundingClientRect();
    let best = -1, bestDistance = 24;
    for (let i = 0; i < positions.length; ++i) {
      const p = view.screenPosition(i);
      const distance = Math.hypot(event.clientX - box.left - p.x, event.clientY - box.top - p.y);
      if (p.inFront && distance < bestDistance) [best, bestDistance] = [i, distance];
    }
    if (best >= 0) onKeyframe(best);
  });

  element.addEventListener('keydown', event => {
    const offset = camera.position.clone().sub(controls.target);
    const toUp = new THREE.Quaternion().setFromUnitVectors(camera.up, new THREE.Vector3(0, 1, 0));
    const spherical = new THREE.Spherical().setFromVector3(offset.applyQuaternion(toUp));
    const actions = {
      ArrowLeft: () => { spherical.theta -= 0.1; },
      ArrowRight: () => { spherical.theta += 0.1; },
      ArrowUp: () => { spherical.phi -= 0.1; },
      ArrowDown: () => { spherical.phi += 0.1; },
      '+': () => { spherical.radius *= 0.9; },
      '-': () => { spherical.radius /= 0.9; },
      n: () => onKeyframe(selected + 1),
      p: () => onKeyframe(selected - 1),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
    spherical.makeSafe();
    offset.setFromSpherical(spherical).applyQuaternion(toUp.inverse());
    camera.position.copy(controls.target).add(offset);
    controls.update();
    render();
  });
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    setBackground();
    render();
  });
  return view;
}
