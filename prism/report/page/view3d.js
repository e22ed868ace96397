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
  let sceneSize = 1;                 // metres
  let halfView = {x: 0.7, y: 0.53};  // tangents
  const textures = new THREE.TextureLoader();
  const picture = {jpeg: '', texture: new THREE.Texture(), exists: false, isWanted: true};
  let selected = 0;

  function render() { renderer.render(scene, camera); }
  controls.addEventListener('change', render);

  function replace(name, object) {
    if (objects[name]) {
      object.visible = objects[name].visible;
      scene.remove(objects[name]);
      objects[name].geometry.dispose();
    }
    if (ON_TOP.includes(name)) {
      object.material.depthTest = false;
      object.renderOrder = 1 + ON_TOP.indexOf(name);
    }
    objects[name] = object;
    scene.add(object);
  }

  function geometryOf(values) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(values), 3));
    return geometry;
  }

  // Seen through points, and through what stands before it in this list.
  const ON_TOP = ['groundtruth', 'trajectory', 'keyframes', 'picture', 'selection', 'spots', 'cursor'];

  function lines(values, color, kind) {
    return new kind(geometryOf(values), new THREE.LineBasicMaterial({color: style(color)}));
  }

  // The corners of a keyframe's picture, from the left upper one on, where it is `size` wide.
  function corners(keyframe, size) {
    const q = new THREE.Quaternion(...keyframe.rotation);
    const t = new THREE.Vector3(...keyframe.position);
    const depth = 0.5 * size / halfView.x;
    return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(
        ([x, y]) => new THREE.Vector3(x * halfView.x * depth, y * halfView.y * depth, depth)
                        .applyQuaternion(q).add(t));
  }

  // The pyramid of its view, as line segments.
  function frustum(keyframe, size) {
    const t = keyframe.position;
    const c = corners(keyframe, size);
    const values = [];
    for (let i = 0; i < 4; ++i) {
      values.push(...t, ...c[i].toArray());
      values.push(...c[i].toArray(), ...c[(i + 1) % 4].toArray());
    }
    return values;
  }

  // Texture of a keyframe's picture, loaded once while it is shown.
  function textureOf(jpeg) {
    if (picture.jpeg === jpeg) return picture.texture;
    picture.texture.dispose();
    picture.jpeg = jpeg;
    element.dataset.picture = '';
    picture.texture = textures.load('data:image/jpeg;base64,' + jpeg, () => {
      if (picture.jpeg === jpeg) element.dataset.picture = 'shown';
      render();
    });
    picture.texture.minFilter = THREE.LinearFilter;  // sides need not be powers of two
    return picture.texture;
  }

  // The picture of a keyframe where its pyramid ends.
  function showPicture(keyframe, size) {
    const c = corners(keyframe, size);
    const geometry = geometryOf([c[0], c[1], c[2], c[0], c[2], c[3]].flatMap(v => v.toArray()));
    geometry.setAttribute('uv', new THREE.BufferAttribute(
        new Float32Array([0, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 0]), 2));
    const material = new THREE.MeshBasicMaterial({side: THREE.DoubleSide});
    if (keyframe.jpeg) material.map = textureOf(keyframe.jpeg);
    replace('picture', new THREE.Mesh(geometry, material));
    picture.exists = Boolean(keyframe.jpeg);
    objects.picture.visible = picture.isWanted && picture.exists;
  }

  function setBackground() { scene.background = new THREE.Color(style('--ground')); }

  const view = {
    // `pieces`: of each position the part of the map it belongs to; parts that are not known relative
    // to each other are not connected and have a colour each. Undefined: there is one. `fractions`:
    // of each position its place in colorAt; null: it has none, or there are no such colours.
    setTrajectory(values, pieces, fractions) {
      const spots = [], spotColors = [];
      (fractions || []).forEach((fraction, i) => {
        if (fraction === null) return;
        spots.push(...values.slice(3 * i, 3 * i + 3));
        spotColors.push(...colorAt(fraction).map(c => c / 255));
      });
      const spotGeometry = geometryOf(spots);
      spotGeometry.setAttribute('color',
                                new THREE.BufferAttribute(new Float32Array(spotColors), 3));
      replace('spots', new THREE.Points(spotGeometry, new THREE.PointsMaterial(
          {size: 6, sizeAttenuation: false, vertexColors: THREE.VertexColors})));
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
      replace('trajectory', new THREE.LineSegments(
          geometry, new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors})));
    },
    setGroundtruth(values) { replace('groundtruth', lines(values, '--truth', THREE.Line)); },

    setCloud(xyz, rgb) {
      const geometry = geometryOf(xyz);
      geometry.setAttribute(
          'color', new THREE.BufferAttribute(Float32Array.from(rgb, c => c / 255), 3));
      const material = new THREE.PointsMaterial(
          {size: 1.8, sizeAttenuation: false, vertexColors: THREE.VertexColors});
      replace('cloud', new THREE.Points(geometry, material));
    },

    setKeyframes(keyframes) {
      positions.length = 0;
      const values = [];
      for (const keyframe of keyframes) {
        positions.push(new THREE.Vector3(...keyframe.position));
        for (const value of frustum(keyframe, frustumSize)) values.push(value);
      }
      replace('keyframes', lines(values, '--keyframe', THREE.LineSegments));
    },

    select(index, keyframe) {
      selected = index;
      const size = Math.max(3 * frustumSize, 0.1 * sceneSize);
      showPicture(keyframe, size);
      replace('selection', lines(frustum(keyframe, size), '--ink', THREE.LineSegments));
      render();
    },

    // The place of the frame that is looked at; null: it has none.
    setCursor(position) {
      replace('cursor', new THREE.Points(
          geometryOf(position || []), new THREE.PointsMaterial(
              {size: 9, sizeAttenuation: false, color: style('--bad')})));
      objects.cursor.visible = position !== null;
      render();
    },

    setVisible(name, visible) {
      if (name === 'picture') {
        picture.isWanted = visible;
        visible = visible && picture.exists;
      }
      if (objects[name]) objects[name].visible = visible;
      render();
    },

    // Looks at trajectory and points from behind and above, all of them in view.
    reset() {
      const values = name => objects[name] ? objects[name].geometry.attributes.position.array : [];
      const all = boundsOf([...values('trajectory'), ...values('groundtruth')], values('cloud'));
      const box = new THREE.Box3(new THREE.Vector3(...all.low), new THREE.Vector3(...all.high));
      sceneSize = Math.max(box.getSize(new THREE.Vector3()).length(), 0.1);
      box.getCenter(controls.target);
      const direction = new THREE.Vector3(0.25, -0.6, -1).normalize();
      camera.position.copy(controls.target).add(direction);
      camera.lookAt(controls.target);
      const right = new THREE.Vector3(), up = new THREE.Vector3();
      camera.updateMatrixWorld();
      camera.matrixWorld.extractBasis(right, up, new THREE.Vector3());
      // As near as all that counts stays in view.
      const tangent = 0.92 * Math.tan(camera.fov * Math.PI / 360);
      let distance = 0.05;
      const keepInView = point => {
        const p = point.sub(controls.target);
        const side = Math.max(Math.abs(p.dot(right)) / (tangent * camera.aspect),
                              Math.abs(p.dot(up)) / tangent);
        distance = Math.max(distance, side + p.dot(direction));
      };
      for (const name of ['trajectory', 'groundtruth', 'cloud']) {
        const xyz = values(name);
        const step = 3 * Math.ceil(xyz.length / 30000);
        for (let i = 0; i < xyz.length; i += step) {
          const point = new THREE.Vector3(xyz[i], xyz[i + 1], xyz[i + 2]);
          if (box.containsPoint(point)) keepInView(point);
        }
      }
      camera.position.copy(controls.target).addScaledVector(direction, distance);
      camera.near = 0.001 * sceneSize;
      camera.far = 1000 * sceneSize;
      camera.updateProjectionMatrix();
      controls.update();
      render();
    },

    // The size of a keyframe's pyramid goes with that of the trajectory.
    setExtent(metres) { frustumSize = Math.max(0.01, 0.035 * metres); },
    // Tangents of half the angles of view of the keyframes.
    setView([x, y]) {
      if (x > 0 && y > 0) halfView = {x, y};
    },

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
