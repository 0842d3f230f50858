(()=>{function Ze(e){return`var(--${e})`}function uu(e){let t=document.createElement("span");t.style.color=Ze(e),document.body.append(t);let{color:n}=getComputedStyle(t);return t.remove(),n}function W_(e){document.documentElement.addEventListener("theme",e),matchMedia("(prefers-color-scheme: dark)").addEventListener("change",e)}function lu(e){let t=document.documentElement;e===void 0?delete t.dataset.theme:t.dataset.theme=e,t.dispatchEvent(new Event("theme"))}function $_(){let e;addEventListener("beforeprint",()=>{e=document.documentElement.dataset.theme,lu("light")}),addEventListener("afterprint",()=>lu(e))}function Ht(e,t={},...n){let i=document.createElement(e);for(let[r,s]of Object.entries(t))r.startsWith("on")?i.addEventListener(r.slice(2),s):s===!0?i.setAttribute(r,""):s!==!1&&s!==void 0&&i.setAttribute(r,s);return i.append(...n),i}function ei(e,t={}){let n=document.createElementNS("http://www.w3.org/2000/svg",e);for(let[i,r]of Object.entries(t))n.setAttribute(i,r);return n}function vp(e){let t=ei("svg",{viewBox:"0 0 24 24","aria-hidden":"true"});return t.append(ei("path",{d:e})),t}var A3="M8 5v14l11-7z",E3="M7 5h4v14H7zM13 5h4v14h-4z",C3="M15.5 5.5 9 12l6.5 6.5",R3="M8.5 5.5 15 12l-6.5 6.5";function q_(e,t,n,i){t.length>1&&e.append(I3(t,n),P3(n)),i&&e.append(bp(n),Mp(n)),e.append(L3())}function bp(e){let t=Ht("button",{type:"button",class:"play",onclick:e.toggle});function n(){t.replaceChildren(vp(e.state.playing?E3:A3)),t.setAttribute("aria-label",e.state.playing?"Pause":"Play")}return e.listen(i=>i==="playing"&&n()),n(),t}function Mp(e){let t=Ht("output",{class:"time","aria-live":"off"});function n(){let{time:i,span:r}=e.state;t.textContent=`${i.toFixed(2)} of ${r[1].toFixed(2)} s`}return e.listen(i=>(i==="time"||i==="span")&&n()),n(),t}function I3(e,t){let n=Ht("select",{id:"trial"},...e.map(a=>Ht("option",{value:a,selected:a===t.state.trial},String(a)))),i=a=>{let c=e[e.indexOf(t.state.trial)+a];c!==void 0&&t.choose(c)},r=X_("Trial before",C3,()=>i(-1)),s=X_("Next trial",R3,()=>i(1));function o(){n.value=String(t.state.trial),r.disabled=t.state.trial===e[0],s.disabled=t.state.trial===e.at(-1)}return n.addEventListener("change",()=>t.choose(Number(n.value))),t.listen(a=>a==="trial"&&o()),o(),Ht("div",{class:"chooser"},Ht("label",{for:"trial"},"Trial"),r,n,s)}function P3(e){let t=Ht("p",{class:"printed"}),n=()=>{t.textContent=`Shown: trial ${e.state.trial}.`};return e.listen(i=>i==="trial"&&n()),n(),t}function X_(e,t,n){return Ht("button",{type:"button",class:"step","aria-label":e,onclick:n},vp(t))}function L3(){let e=Ht("select",{id:"theme","aria-label":"Colours"},...["as the system","light","dark"].map(t=>Ht("option",{value:t},t)));return e.addEventListener("change",()=>{lu(e.value==="as the system"?void 0:e.value)}),Ht("div",{class:"theme"},e)}function Y_(e){let t=new Set,n=!1,i={trial:e,time:0,playing:!1,speed:1,span:[0,0]},r=0,s=u=>t.forEach(h=>h(u,i));function o(u){n=!1,i.time=Math.min(Math.max(u,i.span[0]),i.span[1]),s("time")}function a(u){if(!i.playing)return;let h=i.time+(u-r)/1e3*i.speed;if(r=u,h>=i.span[1]){o(i.span[1]),l();return}o(h),requestAnimationFrame(a)}function c(){i.playing||i.span[1]<=i.span[0]||((n||i.time>=i.span[1])&&o(i.span[0]),i.playing=!0,r=performance.now(),s("playing"),requestAnimationFrame(a))}function l(){i.playing&&(i.playing=!1,s("playing"))}return{state:i,seek:o,play:c,pause:l,open(u){o(u),n=!0},toggle:()=>i.playing?l():c(),choose(u){i.trial=u,s("trial")},setSpeed(u){i.speed=u,s("speed")},setSpan(u,h){i.span=[u,h],s("span"),o(i.time)},listen:u=>t.add(u)}}function Z_(e){let t=new Map([...e.querySelectorAll("a")].map(r=>[r.hash.slice(1),r])),n=new Set,i=new IntersectionObserver(r=>{for(let{target:o,isIntersecting:a}of r)a?n.add(o.id):n.delete(o.id);let s=[...t.keys()].find(o=>n.has(o));for(let[o,a]of t)o===s?a.setAttribute("aria-current","location"):a.removeAttribute("aria-current")},{rootMargin:"-72px 0px -55% 0px"});for(let r of t.keys())i.observe(document.getElementById(decodeURIComponent(r)))}function J_(e){let t=Ht("div",{class:"stage-place"});e.before(t),t.append(e),new IntersectionObserver(n=>{let{isIntersecting:i,boundingClientRect:r}=n.at(-1);e.classList.toggle("docked",!i&&r.bottom<innerHeight/2)}).observe(t)}function K_(e,t){let n=({vertices:o,faces:a})=>({vertices:Float32Array.from(t(o)),faces:t(a)}),i=({frames:o,bodies:a,orientations:c,positions:l})=>({frames:o,bodies:a,orientations:t(c),positions:t(l)}),r=(o,a)=>Object.fromEntries(Object.entries(o).map(([c,l])=>[c,a(l)])),s=({start_s:o,step_s:a,hands:c,objects:l})=>({start:o,step:a,hands:r(c,i),objects:i(l)});return{view:e.view,shapes:r(e.shapes,o=>o.map(n)),objects:e.objects,motions:new Map(Object.entries(e.trials).map(([o,a])=>[Number(o),s(a)]))}}function j_({hands:e,objects:t}){return Math.max(t.frames,...Object.values(e).map(({frames:n})=>n),0)}var Sv=0,Jp=1,wv=2;var kc=1,Tv=2,na=3,ys=0,Tn=1,si=2,Zs=0,ia=1,Kp=2,jp=3,Qp=4,Av=5;var Js=100,Ev=101,Cv=102,Rv=103,Iv=104,Pv=200,Lv=201,Nv=202,Dv=203,tm=204,em=205,Fv=206,Uv=207,Ov=208,Bv=209,kv=210,zv=211,Gv=212,Vv=213,Hv=214,Nu=0,Du=1,Fu=2,qo=3,Uu=4,Ou=5,Bu=6,ku=7,hf=0,Wv=1,$v=2,Yi=0,nm=1,im=2,rm=3,sm=4,om=5,am=6,cm=7;var lm=300,Ks=301,ra=302,df=303,pf=304,zu=1e3,$i=1001,Gu=1002,je=1003,Xv=1004;var zc=1005;var Mn=1006,mf=1007;var Pr=1008;var On=1009,um=1010,fm=1011,sa=1012,gf=1013,Ci=1014,Ri=1015,Ii=1016,yf=1017,xf=1018,js=1020,hm=35902,dm=35899,pm=1021,mm=1022,Pi=1023,Cr=1026,Lr=1027,gm=1028,_f=1029,xs=1030,vf=1031;var bf=1033,Gc=33776,Vc=33777,Hc=33778,Wc=33779,Mf=35840,Sf=35841,wf=35842,Tf=35843,Af=36196,Ef=37492,Cf=37496,Rf=37488,If=37489,$c=37490,Pf=37491,Lf=37808,Nf=37809,Df=37810,Ff=37811,Uf=37812,Of=37813,Bf=37814,kf=37815,zf=37816,Gf=37817,Vf=37818,Hf=37819,Wf=37820,$f=37821,Xf=36492,qf=36494,Yf=36495,Zf=36283,Jf=36284,Xc=36285,Kf=36286;var _c=2300,Vu=2301,Pu=2302,Hp=2303,Wp=2400,$p=2401,Xp=2402;var qv=3200;var jf=0,Yv=1,Nr="",Xn="srgb",vc="srgb-linear",bc="linear",ue="srgb";var Lu=7680;var Zv=519,Jv=512,Kv=513,jv=514,ym=515,Qv=516,tb=517,xm=518,_m=519,eb=35044;var vm="300 es",ii=2e3,Yo=2001;function N3(e){for(let t=e.length-1;t>=0;--t)if(e[t]>=65535)return!0;return!1}function D3(e){return ArrayBuffer.isView(e)&&!(e instanceof DataView)}function Mc(e){return document.createElementNS("http://www.w3.org/1999/xhtml",e)}function nb(){let e=Mc("canvas");return e.style.display="block",e}var Q_={},Zo=null;function bm(...e){let t="THREE."+e.shift();Zo?Zo("log",t,...e):console.log(t,...e)}function ib(e){let t=e[0];if(typeof t=="string"&&t.startsWith("TSL:")){let n=e[1];n&&n.isStackTrace?e[0]+=" "+n.getLocation():e[1]='Stack trace not available. Enable "THREE.Node.captureStackTrace" to capture stack traces.'}return e}function Ft(...e){e=ib(e);let t="THREE."+e.shift();if(Zo)Zo("warn",t,...e);else{let n=e[0];n&&n.isStackTrace?console.warn(n.getError(t)):console.warn(t,...e)}}function kt(...e){e=ib(e);let t="THREE."+e.shift();if(Zo)Zo("error",t,...e);else{let n=e[0];n&&n.isStackTrace?console.error(n.getError(t)):console.error(t,...e)}}function gc(...e){let t=e.join(" ");t in Q_||(Q_[t]=!0,Ft(...e))}function rb(e,t,n){return new Promise(function(i,r){function s(){switch(e.clientWaitSync(t,e.SYNC_FLUSH_COMMANDS_BIT,0)){case e.WAIT_FAILED:r();break;case e.TIMEOUT_EXPIRED:setTimeout(s,n);break;default:i()}}setTimeout(s,n)})}var sb={[Nu]:Nu,[Fu]:Bu,[Uu]:Uu,[qo]:Ou,[Du]:Du,[Bu]:Fu,[ku]:ku,[Ou]:qo},Xi=class{addEventListener(t,n){this._listeners===void 0&&(this._listeners={});let i=this._listeners;i[t]===void 0&&(i[t]=[]),i[t].indexOf(n)===-1&&i[t].push(n)}hasEventListener(t,n){let i=this._listeners;return i===void 0?!1:i[t]!==void 0&&i[t].indexOf(n)!==-1}removeEventListener(t,n){let i=this._listeners;if(i===void 0)return;let r=i[t];if(r!==void 0){let s=r.indexOf(n);s!==-1&&r.splice(s,1)}}dispatchEvent(t){let n=this._listeners;if(n===void 0)return;let i=n[t.type];if(i!==void 0){t.target=this;let r=i.slice(0);for(let s=0,o=r.length;s<o;s++)r[s].call(this,t);t.target=null}}},dn=["00","01","02","03","04","05","06","07","08","09","0a","0b","0c","0d","0e","0f","10","11","12","13","14","15","16","17","18","19","1a","1b","1c","1d","1e","1f","20","21","22","23","24","25","26","27","28","29","2a","2b","2c","2d","2e","2f","30","31","32","33","34","35","36","37","38","39","3a","3b","3c","3d","3e","3f","40","41","42","43","44","45","46","47","48","49","4a","4b","4c","4d","4e","4f","50","51","52","53","54","55","56","57","58","59","5a","5b","5c","5d","5e","5f","60","61","62","63","64","65","66","67","68","69","6a","6b","6c","6d","6e","6f","70","71","72","73","74","75","76","77","78","79","7a","7b","7c","7d","7e","7f","80","81","82","83","84","85","86","87","88","89","8a","8b","8c","8d","8e","8f","90","91","92","93","94","95","96","97","98","99","9a","9b","9c","9d","9e","9f","a0","a1","a2","a3","a4","a5","a6","a7","a8","a9","aa","ab","ac","ad","ae","af","b0","b1","b2","b3","b4","b5","b6","b7","b8","b9","ba","bb","bc","bd","be","bf","c0","c1","c2","c3","c4","c5","c6","c7","c8","c9","ca","cb","cc","cd","ce","cf","d0","d1","d2","d3","d4","d5","d6","d7","d8","d9","da","db","dc","dd","de","df","e0","e1","e2","e3","e4","e5","e6","e7","e8","e9","ea","eb","ec","ed","ee","ef","f0","f1","f2","f3","f4","f5","f6","f7","f8","f9","fa","fb","fc","fd","fe","ff"],tv=1234567,yc=Math.PI/180,Jo=180/Math.PI;function oa(){let e=Math.random()*4294967295|0,t=Math.random()*4294967295|0,n=Math.random()*4294967295|0,i=Math.random()*4294967295|0;return(dn[e&255]+dn[e>>8&255]+dn[e>>16&255]+dn[e>>24&255]+"-"+dn[t&255]+dn[t>>8&255]+"-"+dn[t>>16&15|64]+dn[t>>24&255]+"-"+dn[n&63|128]+dn[n>>8&255]+"-"+dn[n>>16&255]+dn[n>>24&255]+dn[i&255]+dn[i>>8&255]+dn[i>>16&255]+dn[i>>24&255]).toLowerCase()}function ne(e,t,n){return Math.max(t,Math.min(n,e))}function Mm(e,t){return(e%t+t)%t}function F3(e,t,n,i,r){return i+(e-t)*(r-i)/(n-t)}function U3(e,t,n){return e!==t?(n-e)/(t-e):0}function xc(e,t,n){return(1-n)*e+n*t}function O3(e,t,n,i){return xc(e,t,1-Math.exp(-n*i))}function B3(e,t=1){return t-Math.abs(Mm(e,t*2)-t)}function k3(e,t,n){return e<=t?0:e>=n?1:(e=(e-t)/(n-t),e*e*(3-2*e))}function z3(e,t,n){return e<=t?0:e>=n?1:(e=(e-t)/(n-t),e*e*e*(e*(e*6-15)+10))}function G3(e,t){return e+Math.floor(Math.random()*(t-e+1))}function V3(e,t){return e+Math.random()*(t-e)}function H3(e){return e*(.5-Math.random())}function W3(e){e!==void 0&&(tv=e);let t=tv+=1831565813;return t=Math.imul(t^t>>>15,t|1),t^=t+Math.imul(t^t>>>7,t|61),((t^t>>>14)>>>0)/4294967296}function $3(e){return e*yc}function X3(e){return e*Jo}function q3(e){return e>0&&Number.isInteger(e)&&2**Math.round(Math.log2(e))===e}function Y3(e){return Math.pow(2,Math.ceil(Math.log(e)/Math.LN2))}function Sm(e){return Math.pow(2,Math.floor(Math.log(e)/Math.LN2))}function Z3(e,t,n,i,r){let s=Math.cos,o=Math.sin,a=s(n/2),c=o(n/2),l=s((t+i)/2),u=o((t+i)/2),h=s((t-i)/2),f=o((t-i)/2),d=s((i-t)/2),p=o((i-t)/2);switch(r){case"XYX":e.set(a*u,c*h,c*f,a*l);break;case"YZY":e.set(c*f,a*u,c*h,a*l);break;case"ZXZ":e.set(c*h,c*f,a*u,a*l);break;case"XZX":e.set(a*u,c*p,c*d,a*l);break;case"YXY":e.set(c*d,a*u,c*p,a*l);break;case"ZYZ":e.set(c*p,c*d,a*u,a*l);break;default:Ft("MathUtils: .setQuaternionFromProperEuler() encountered an unknown order: "+r)}}function wm(e){switch(e.constructor){case Uint32Array:return 4294967295;case Uint16Array:return 65535;case Uint8Array:case Uint8ClampedArray:return 255;case Int32Array:return 2147483647;case Int16Array:return 32767;case Int8Array:return 127;default:return}}function ob(e,t){if(t.constructor===Float32Array)return e;let n=wm(t);if(n===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.max(e/n,-1)}function ab(e,t){if(t.constructor===Float32Array)return e;let n=wm(t);if(n===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.round(e*n)}var Tm={DEG2RAD:yc,RAD2DEG:Jo,generateUUID:oa,clamp:ne,euclideanModulo:Mm,mapLinear:F3,inverseLerp:U3,lerp:xc,damp:O3,pingpong:B3,smoothstep:k3,smootherstep:z3,randInt:G3,randFloat:V3,randFloatSpread:H3,seededRandom:W3,degToRad:$3,radToDeg:X3,isPowerOfTwo:q3,ceilPowerOfTwo:Y3,floorPowerOfTwo:Sm,setQuaternionFromProperEuler:Z3,normalize:ab,denormalize:ob},ie=class{static{this.prototype.isVector2=!0}constructor(t=0,n=0){this.x=t,this.y=n}get width(){return this.x}set width(t){this.x=t}get height(){return this.y}set height(t){this.y=t}set(t,n){return this.x=t,this.y=n,this}setScalar(t){return this.x=t,this.y=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setComponent(t,n){switch(t){case 0:this.x=n;break;case 1:this.y=n;break;default:throw new Error("THREE.Vector2: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;default:throw new Error("THREE.Vector2: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y)}copy(t){return this.x=t.x,this.y=t.y,this}add(t){return this.x+=t.x,this.y+=t.y,this}addScalar(t){return this.x+=t,this.y+=t,this}addVectors(t,n){return this.x=t.x+n.x,this.y=t.y+n.y,this}addScaledVector(t,n){return this.x+=t.x*n,this.y+=t.y*n,this}sub(t){return this.x-=t.x,this.y-=t.y,this}subScalar(t){return this.x-=t,this.y-=t,this}subVectors(t,n){return this.x=t.x-n.x,this.y=t.y-n.y,this}multiply(t){return this.x*=t.x,this.y*=t.y,this}multiplyScalar(t){return this.x*=t,this.y*=t,this}divide(t){return this.x/=t.x,this.y/=t.y,this}divideScalar(t){return this.multiplyScalar(1/t)}applyMatrix3(t){let n=this.x,i=this.y,r=t.elements;return this.x=r[0]*n+r[3]*i+r[6],this.y=r[1]*n+r[4]*i+r[7],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this}clamp(t,n){return this.x=ne(this.x,t.x,n.x),this.y=ne(this.y,t.y,n.y),this}clampScalar(t,n){return this.x=ne(this.x,t,n),this.y=ne(this.y,t,n),this}clampLength(t,n){let i=this.length();return this.divideScalar(i||1).multiplyScalar(ne(i,t,n))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this}negate(){return this.x=-this.x,this.y=-this.y,this}dot(t){return this.x*t.x+this.y*t.y}cross(t){return this.x*t.y-this.y*t.x}lengthSq(){return this.x*this.x+this.y*this.y}length(){return Math.sqrt(this.x*this.x+this.y*this.y)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)}normalize(){return this.divideScalar(this.length()||1)}angle(){return Math.atan2(-this.y,-this.x)+Math.PI}angleTo(t){let n=Math.sqrt(this.lengthSq()*t.lengthSq());if(n===0)return Math.PI/2;let i=this.dot(t)/n;return Math.acos(ne(i,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let n=this.x-t.x,i=this.y-t.y;return n*n+i*i}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,n){return this.x+=(t.x-this.x)*n,this.y+=(t.y-this.y)*n,this}lerpVectors(t,n,i){return this.x=t.x+(n.x-t.x)*i,this.y=t.y+(n.y-t.y)*i,this}equals(t){return t.x===this.x&&t.y===this.y}fromArray(t,n=0){return this.x=t[n],this.y=t[n+1],this}toArray(t=[],n=0){return t[n]=this.x,t[n+1]=this.y,t}fromBufferAttribute(t,n){return this.x=t.getX(n),this.y=t.getY(n),this}rotateAround(t,n){let i=Math.cos(n),r=Math.sin(n),s=this.x-t.x,o=this.y-t.y;return this.x=s*i-o*r+t.x,this.y=s*r+o*i+t.y,this}random(){return this.x=Math.random(),this.y=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y}},Sn=class{constructor(t=0,n=0,i=0,r=1){this.isQuaternion=!0,this._x=t,this._y=n,this._z=i,this._w=r}static slerpFlat(t,n,i,r,s,o,a){let c=i[r+0],l=i[r+1],u=i[r+2],h=i[r+3],f=s[o+0],d=s[o+1],p=s[o+2],y=s[o+3];if(h!==y||c!==f||l!==d||u!==p){let m=c*f+l*d+u*p+h*y;m<0&&(f=-f,d=-d,p=-p,y=-y,m=-m);let g=1-a;if(m<.9995){let v=Math.acos(m),S=Math.sin(v);g=Math.sin(g*v)/S,a=Math.sin(a*v)/S,c=c*g+f*a,l=l*g+d*a,u=u*g+p*a,h=h*g+y*a}else{c=c*g+f*a,l=l*g+d*a,u=u*g+p*a,h=h*g+y*a;let v=1/Math.sqrt(c*c+l*l+u*u+h*h);c*=v,l*=v,u*=v,h*=v}}t[n]=c,t[n+1]=l,t[n+2]=u,t[n+3]=h}static multiplyQuaternionsFlat(t,n,i,r,s,o){let a=i[r],c=i[r+1],l=i[r+2],u=i[r+3],h=s[o],f=s[o+1],d=s[o+2],p=s[o+3];return t[n]=a*p+u*h+c*d-l*f,t[n+1]=c*p+u*f+l*h-a*d,t[n+2]=l*p+u*d+a*f-c*h,t[n+3]=u*p-a*h-c*f-l*d,t}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get w(){return this._w}set w(t){this._w=t,this._onChangeCallback()}set(t,n,i,r){return this._x=t,this._y=n,this._z=i,this._w=r,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._w)}copy(t){return this._x=t.x,this._y=t.y,this._z=t.z,this._w=t.w,this._onChangeCallback(),this}setFromEuler(t,n=!0){let i=t._x,r=t._y,s=t._z,o=t._order,a=Math.cos,c=Math.sin,l=a(i/2),u=a(r/2),h=a(s/2),f=c(i/2),d=c(r/2),p=c(s/2);switch(o){case"XYZ":this._x=f*u*h+l*d*p,this._y=l*d*h-f*u*p,this._z=l*u*p+f*d*h,this._w=l*u*h-f*d*p;break;case"YXZ":this._x=f*u*h+l*d*p,this._y=l*d*h-f*u*p,this._z=l*u*p-f*d*h,this._w=l*u*h+f*d*p;break;case"ZXY":this._x=f*u*h-l*d*p,this._y=l*d*h+f*u*p,this._z=l*u*p+f*d*h,this._w=l*u*h-f*d*p;break;case"ZYX":this._x=f*u*h-l*d*p,this._y=l*d*h+f*u*p,this._z=l*u*p-f*d*h,this._w=l*u*h+f*d*p;break;case"YZX":this._x=f*u*h+l*d*p,this._y=l*d*h+f*u*p,this._z=l*u*p-f*d*h,this._w=l*u*h-f*d*p;break;case"XZY":this._x=f*u*h-l*d*p,this._y=l*d*h-f*u*p,this._z=l*u*p+f*d*h,this._w=l*u*h+f*d*p;break;default:Ft("Quaternion: .setFromEuler() encountered an unknown order: "+o)}return n===!0&&this._onChangeCallback(),this}setFromAxisAngle(t,n){let i=n/2,r=Math.sin(i);return this._x=t.x*r,this._y=t.y*r,this._z=t.z*r,this._w=Math.cos(i),this._onChangeCallback(),this}setFromRotationMatrix(t){let n=t.elements,i=n[0],r=n[4],s=n[8],o=n[1],a=n[5],c=n[9],l=n[2],u=n[6],h=n[10],f=i+a+h;if(f>0){let d=.5/Math.sqrt(f+1);this._w=.25/d,this._x=(u-c)*d,this._y=(s-l)*d,this._z=(o-r)*d}else if(i>a&&i>h){let d=2*Math.sqrt(1+i-a-h);this._w=(u-c)/d,this._x=.25*d,this._y=(r+o)/d,this._z=(s+l)/d}else if(a>h){let d=2*Math.sqrt(1+a-i-h);this._w=(s-l)/d,this._x=(r+o)/d,this._y=.25*d,this._z=(c+u)/d}else{let d=2*Math.sqrt(1+h-i-a);this._w=(o-r)/d,this._x=(s+l)/d,this._y=(c+u)/d,this._z=.25*d}return this._onChangeCallback(),this}setFromUnitVectors(t,n){let i=t.dot(n)+1;return i<1e-8?(i=0,Math.abs(t.x)>Math.abs(t.z)?(this._x=-t.y,this._y=t.x,this._z=0,this._w=i):(this._x=0,this._y=-t.z,this._z=t.y,this._w=i)):(this._x=t.y*n.z-t.z*n.y,this._y=t.z*n.x-t.x*n.z,this._z=t.x*n.y-t.y*n.x,this._w=i),this.normalize()}angleTo(t){return 2*Math.acos(Math.abs(ne(this.dot(t),-1,1)))}rotateTowards(t,n){let i=this.angleTo(t);if(i===0)return this;let r=Math.min(1,n/i);return this.slerp(t,r),this}identity(){return this.set(0,0,0,1)}invert(){return this.conjugate()}conjugate(){return this._x*=-1,this._y*=-1,this._z*=-1,this._onChangeCallback(),this}dot(t){return this._x*t._x+this._y*t._y+this._z*t._z+this._w*t._w}lengthSq(){return this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w}length(){return Math.sqrt(this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w)}normalize(){let t=this.length();return t===0?(this._x=0,this._y=0,this._z=0,this._w=1):(t=1/t,this._x=this._x*t,this._y=this._y*t,this._z=this._z*t,this._w=this._w*t),this._onChangeCallback(),this}multiply(t){return this.multiplyQuaternions(this,t)}premultiply(t){return this.multiplyQuaternions(t,this)}multiplyQuaternions(t,n){let i=t._x,r=t._y,s=t._z,o=t._w,a=n._x,c=n._y,l=n._z,u=n._w;return this._x=i*u+o*a+r*l-s*c,this._y=r*u+o*c+s*a-i*l,this._z=s*u+o*l+i*c-r*a,this._w=o*u-i*a-r*c-s*l,this._onChangeCallback(),this}slerp(t,n){let i=t._x,r=t._y,s=t._z,o=t._w,a=this.dot(t);a<0&&(i=-i,r=-r,s=-s,o=-o,a=-a);let c=1-n;if(a<.9995){let l=Math.acos(a),u=Math.sin(l);c=Math.sin(c*l)/u,n=Math.sin(n*l)/u,this._x=this._x*c+i*n,this._y=this._y*c+r*n,this._z=this._z*c+s*n,this._w=this._w*c+o*n,this._onChangeCallback()}else this._x=this._x*c+i*n,this._y=this._y*c+r*n,this._z=this._z*c+s*n,this._w=this._w*c+o*n,this.normalize();return this}slerpQuaternions(t,n,i){return this.copy(t).slerp(n,i)}random(){let t=2*Math.PI*Math.random(),n=2*Math.PI*Math.random(),i=Math.random(),r=Math.sqrt(1-i),s=Math.sqrt(i);return this.set(r*Math.sin(t),r*Math.cos(t),s*Math.sin(n),s*Math.cos(n))}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._w===this._w}fromArray(t,n=0){return this._x=t[n],this._y=t[n+1],this._z=t[n+2],this._w=t[n+3],this._onChangeCallback(),this}toArray(t=[],n=0){return t[n]=this._x,t[n+1]=this._y,t[n+2]=this._z,t[n+3]=this._w,t}fromBufferAttribute(t,n){return this._x=t.getX(n),this._y=t.getY(n),this._z=t.getZ(n),this._w=t.getW(n),this._onChangeCallback(),this}toJSON(){return this.toArray()}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._w}},W=class{static{this.prototype.isVector3=!0}constructor(t=0,n=0,i=0){this.x=t,this.y=n,this.z=i}set(t,n,i){return i===void 0&&(i=this.z),this.x=t,this.y=n,this.z=i,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setComponent(t,n){switch(t){case 0:this.x=n;break;case 1:this.y=n;break;case 2:this.z=n;break;default:throw new Error("THREE.Vector3: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;default:throw new Error("THREE.Vector3: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this}addVectors(t,n){return this.x=t.x+n.x,this.y=t.y+n.y,this.z=t.z+n.z,this}addScaledVector(t,n){return this.x+=t.x*n,this.y+=t.y*n,this.z+=t.z*n,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this}subVectors(t,n){return this.x=t.x-n.x,this.y=t.y-n.y,this.z=t.z-n.z,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this}multiplyVectors(t,n){return this.x=t.x*n.x,this.y=t.y*n.y,this.z=t.z*n.z,this}applyEuler(t){return this.applyQuaternion(ev.setFromEuler(t))}applyAxisAngle(t,n){return this.applyQuaternion(ev.setFromAxisAngle(t,n))}applyMatrix3(t){let n=this.x,i=this.y,r=this.z,s=t.elements;return this.x=s[0]*n+s[3]*i+s[6]*r,this.y=s[1]*n+s[4]*i+s[7]*r,this.z=s[2]*n+s[5]*i+s[8]*r,this}applyNormalMatrix(t){return this.applyMatrix3(t).normalize()}applyMatrix4(t){let n=this.x,i=this.y,r=this.z,s=t.elements,o=1/(s[3]*n+s[7]*i+s[11]*r+s[15]);return this.x=(s[0]*n+s[4]*i+s[8]*r+s[12])*o,this.y=(s[1]*n+s[5]*i+s[9]*r+s[13])*o,this.z=(s[2]*n+s[6]*i+s[10]*r+s[14])*o,this}applyQuaternion(t){let n=this.x,i=this.y,r=this.z,s=t.x,o=t.y,a=t.z,c=t.w,l=2*(o*r-a*i),u=2*(a*n-s*r),h=2*(s*i-o*n);return this.x=n+c*l+o*h-a*u,this.y=i+c*u+a*l-s*h,this.z=r+c*h+s*u-o*l,this}project(t){return this.applyMatrix4(t.matrixWorldInverse).applyMatrix4(t.projectionMatrix)}unproject(t){return this.applyMatrix4(t.projectionMatrixInverse).applyMatrix4(t.matrixWorld)}transformDirection(t){let n=this.x,i=this.y,r=this.z,s=t.elements;return this.x=s[0]*n+s[4]*i+s[8]*r,this.y=s[1]*n+s[5]*i+s[9]*r,this.z=s[2]*n+s[6]*i+s[10]*r,this.normalize()}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this}divideScalar(t){return this.multiplyScalar(1/t)}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this}clamp(t,n){return this.x=ne(this.x,t.x,n.x),this.y=ne(this.y,t.y,n.y),this.z=ne(this.z,t.z,n.z),this}clampScalar(t,n){return this.x=ne(this.x,t,n),this.y=ne(this.y,t,n),this.z=ne(this.z,t,n),this}clampLength(t,n){let i=this.length();return this.divideScalar(i||1).multiplyScalar(ne(i,t,n))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,n){return this.x+=(t.x-this.x)*n,this.y+=(t.y-this.y)*n,this.z+=(t.z-this.z)*n,this}lerpVectors(t,n,i){return this.x=t.x+(n.x-t.x)*i,this.y=t.y+(n.y-t.y)*i,this.z=t.z+(n.z-t.z)*i,this}cross(t){return this.crossVectors(this,t)}crossVectors(t,n){let i=t.x,r=t.y,s=t.z,o=n.x,a=n.y,c=n.z;return this.x=r*c-s*a,this.y=s*o-i*c,this.z=i*a-r*o,this}projectOnVector(t){let n=t.lengthSq();if(n===0)return this.set(0,0,0);let i=t.dot(this)/n;return this.copy(t).multiplyScalar(i)}projectOnPlane(t){return Sp.copy(this).projectOnVector(t),this.sub(Sp)}reflect(t){return this.sub(Sp.copy(t).multiplyScalar(2*this.dot(t)))}angleTo(t){let n=Math.sqrt(this.lengthSq()*t.lengthSq());if(n===0)return Math.PI/2;let i=this.dot(t)/n;return Math.acos(ne(i,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let n=this.x-t.x,i=this.y-t.y,r=this.z-t.z;return n*n+i*i+r*r}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)+Math.abs(this.z-t.z)}setFromSpherical(t){return this.setFromSphericalCoords(t.radius,t.phi,t.theta)}setFromSphericalCoords(t,n,i){let r=Math.sin(n)*t;return this.x=r*Math.sin(i),this.y=Math.cos(n)*t,this.z=r*Math.cos(i),this}setFromCylindrical(t){return this.setFromCylindricalCoords(t.radius,t.theta,t.y)}setFromCylindricalCoords(t,n,i){return this.x=t*Math.sin(n),this.y=i,this.z=t*Math.cos(n),this}setFromMatrixPosition(t){let n=t.elements;return this.x=n[12],this.y=n[13],this.z=n[14],this}setFromMatrixScale(t){let n=this.setFromMatrixColumn(t,0).length(),i=this.setFromMatrixColumn(t,1).length(),r=this.setFromMatrixColumn(t,2).length();return this.x=n,this.y=i,this.z=r,this}setFromMatrixColumn(t,n){return this.fromArray(t.elements,n*4)}setFromMatrix3Column(t,n){return this.fromArray(t.elements,n*3)}setFromEuler(t){return this.x=t._x,this.y=t._y,this.z=t._z,this}setFromColor(t){return this.x=t.r,this.y=t.g,this.z=t.b,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z}fromArray(t,n=0){return this.x=t[n],this.y=t[n+1],this.z=t[n+2],this}toArray(t=[],n=0){return t[n]=this.x,t[n+1]=this.y,t[n+2]=this.z,t}fromBufferAttribute(t,n){return this.x=t.getX(n),this.y=t.getY(n),this.z=t.getZ(n),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this}randomDirection(){let t=Math.random()*Math.PI*2,n=Math.random()*2-1,i=Math.sqrt(1-n*n);return this.x=i*Math.cos(t),this.y=n,this.z=i*Math.sin(t),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z}},Sp=new W,ev=new Sn,zt=class{static{this.prototype.isMatrix3=!0}constructor(t,n,i,r,s,o,a,c,l){this.elements=[1,0,0,0,1,0,0,0,1],t!==void 0&&this.set(t,n,i,r,s,o,a,c,l)}set(t,n,i,r,s,o,a,c,l){let u=this.elements;return u[0]=t,u[1]=r,u[2]=a,u[3]=n,u[4]=s,u[5]=c,u[6]=i,u[7]=o,u[8]=l,this}identity(){return this.set(1,0,0,0,1,0,0,0,1),this}copy(t){let n=this.elements,i=t.elements;return n[0]=i[0],n[1]=i[1],n[2]=i[2],n[3]=i[3],n[4]=i[4],n[5]=i[5],n[6]=i[6],n[7]=i[7],n[8]=i[8],this}extractBasis(t,n,i){return t.setFromMatrix3Column(this,0),n.setFromMatrix3Column(this,1),i.setFromMatrix3Column(this,2),this}setFromMatrix4(t){let n=t.elements;return this.set(n[0],n[4],n[8],n[1],n[5],n[9],n[2],n[6],n[10]),this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,n){let i=t.elements,r=n.elements,s=this.elements,o=i[0],a=i[3],c=i[6],l=i[1],u=i[4],h=i[7],f=i[2],d=i[5],p=i[8],y=r[0],m=r[3],g=r[6],v=r[1],S=r[4],_=r[7],w=r[2],b=r[5],x=r[8];return s[0]=o*y+a*v+c*w,s[3]=o*m+a*S+c*b,s[6]=o*g+a*_+c*x,s[1]=l*y+u*v+h*w,s[4]=l*m+u*S+h*b,s[7]=l*g+u*_+h*x,s[2]=f*y+d*v+p*w,s[5]=f*m+d*S+p*b,s[8]=f*g+d*_+p*x,this}multiplyScalar(t){let n=this.elements;return n[0]*=t,n[3]*=t,n[6]*=t,n[1]*=t,n[4]*=t,n[7]*=t,n[2]*=t,n[5]*=t,n[8]*=t,this}determinant(){let t=this.elements,n=t[0],i=t[1],r=t[2],s=t[3],o=t[4],a=t[5],c=t[6],l=t[7],u=t[8];return n*o*u-n*a*l-i*s*u+i*a*c+r*s*l-r*o*c}invert(){let t=this.elements,n=t[0],i=t[1],r=t[2],s=t[3],o=t[4],a=t[5],c=t[6],l=t[7],u=t[8],h=u*o-a*l,f=a*c-u*s,d=l*s-o*c,p=n*h+i*f+r*d;if(p===0)return this.set(0,0,0,0,0,0,0,0,0);let y=1/p;return t[0]=h*y,t[1]=(r*l-u*i)*y,t[2]=(a*i-r*o)*y,t[3]=f*y,t[4]=(u*n-r*c)*y,t[5]=(r*s-a*n)*y,t[6]=d*y,t[7]=(i*c-l*n)*y,t[8]=(o*n-i*s)*y,this}transpose(){let t,n=this.elements;return t=n[1],n[1]=n[3],n[3]=t,t=n[2],n[2]=n[6],n[6]=t,t=n[5],n[5]=n[7],n[7]=t,this}getNormalMatrix(t){return this.setFromMatrix4(t).invert().transpose()}transposeIntoArray(t){let n=this.elements;return t[0]=n[0],t[1]=n[3],t[2]=n[6],t[3]=n[1],t[4]=n[4],t[5]=n[7],t[6]=n[2],t[7]=n[5],t[8]=n[8],this}setUvTransform(t,n,i,r,s,o,a){let c=Math.cos(s),l=Math.sin(s);return this.set(i*c,i*l,-i*(c*o+l*a)+o+t,-r*l,r*c,-r*(-l*o+c*a)+a+n,0,0,1),this}scale(t,n){return gc("Matrix3: .scale() is deprecated. Use .makeScale() instead."),this.premultiply(wp.makeScale(t,n)),this}rotate(t){return gc("Matrix3: .rotate() is deprecated. Use .makeRotation() instead."),this.premultiply(wp.makeRotation(-t)),this}translate(t,n){return gc("Matrix3: .translate() is deprecated. Use .makeTranslation() instead."),this.premultiply(wp.makeTranslation(t,n)),this}makeTranslation(t,n){return t.isVector2?this.set(1,0,t.x,0,1,t.y,0,0,1):this.set(1,0,t,0,1,n,0,0,1),this}makeRotation(t){let n=Math.cos(t),i=Math.sin(t);return this.set(n,-i,0,i,n,0,0,0,1),this}makeScale(t,n){return this.set(t,0,0,0,n,0,0,0,1),this}equals(t){let n=this.elements,i=t.elements;for(let r=0;r<9;r++)if(n[r]!==i[r])return!1;return!0}fromArray(t,n=0){for(let i=0;i<9;i++)this.elements[i]=t[i+n];return this}toArray(t=[],n=0){let i=this.elements;return t[n]=i[0],t[n+1]=i[1],t[n+2]=i[2],t[n+3]=i[3],t[n+4]=i[4],t[n+5]=i[5],t[n+6]=i[6],t[n+7]=i[7],t[n+8]=i[8],t}clone(){return new this.constructor().fromArray(this.elements)}},wp=new zt,nv=new zt().set(.4123908,.3575843,.1804808,.212639,.7151687,.0721923,.0193308,.1191948,.9505322),iv=new zt().set(3.2409699,-1.5373832,-.4986108,-.9692436,1.8759675,.0415551,.0556301,-.203977,1.0569715);function J3(){let e={enabled:!0,workingColorSpace:vc,spaces:{},convert:function(r,s,o){return this.enabled===!1||s===o||!s||!o||(this.spaces[s].transfer===ue&&(r.r=Er(r.r),r.g=Er(r.g),r.b=Er(r.b)),this.spaces[s].primaries!==this.spaces[o].primaries&&(r.applyMatrix3(this.spaces[s].toXYZ),r.applyMatrix3(this.spaces[o].fromXYZ)),this.spaces[o].transfer===ue&&(r.r=Xo(r.r),r.g=Xo(r.g),r.b=Xo(r.b))),r},workingToColorSpace:function(r,s){return this.convert(r,this.workingColorSpace,s)},colorSpaceToWorking:function(r,s){return this.convert(r,s,this.workingColorSpace)},getPrimaries:function(r){return this.spaces[r].primaries},getTransfer:function(r){return r===Nr?bc:this.spaces[r].transfer},getToneMappingMode:function(r){return this.spaces[r].outputColorSpaceConfig.toneMappingMode||"standard"},getLuminanceCoefficients:function(r,s=this.workingColorSpace){return r.fromArray(this.spaces[s].luminanceCoefficients)},define:function(r){Object.assign(this.spaces,r)},_getMatrix:function(r,s,o){return r.copy(this.spaces[o].fromXYZ).multiply(this.spaces[s].toXYZ)},_getDrawingBufferColorSpace:function(r){return this.spaces[r].outputColorSpaceConfig.drawingBufferColorSpace},_getUnpackColorSpace:function(r=this.workingColorSpace){return this.spaces[r].workingColorSpaceConfig.unpackColorSpace}},t=[.64,.33,.3,.6,.15,.06],n=[.2126,.7152,.0722],i=[.3127,.329];return e.define({[vc]:{primaries:t,whitePoint:i,transfer:bc,toXYZ:nv,fromXYZ:iv,luminanceCoefficients:n,workingColorSpaceConfig:{unpackColorSpace:Xn},outputColorSpaceConfig:{drawingBufferColorSpace:Xn}},[Xn]:{primaries:t,whitePoint:i,transfer:ue,toXYZ:nv,fromXYZ:iv,luminanceCoefficients:n,outputColorSpaceConfig:{drawingBufferColorSpace:Xn}}}),e}var ee=J3();function Er(e){return e<.04045?e*.0773993808:Math.pow(e*.9478672986+.0521327014,2.4)}function Xo(e){return e<.0031308?e*12.92:1.055*Math.pow(e,.41666)-.055}var No,Hu=class{static getDataURL(t,n="image/png"){if(/^data:/i.test(t.src)||typeof HTMLCanvasElement>"u")return t.src;let i;if(t instanceof HTMLCanvasElement)i=t;else{No===void 0&&(No=Mc("canvas")),No.width=t.width,No.height=t.height;let r=No.getContext("2d");t instanceof ImageData?r.putImageData(t,0,0):r.drawImage(t,0,0,t.width,t.height),i=No}return i.toDataURL(n)}static sRGBToLinear(t){if(typeof HTMLImageElement<"u"&&t instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&t instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&t instanceof ImageBitmap){let n=Mc("canvas");n.width=t.width,n.height=t.height;let i=n.getContext("2d");i.drawImage(t,0,0,t.width,t.height);let r=i.getImageData(0,0,t.width,t.height),s=r.data;for(let o=0;o<s.length;o++)s[o]=Er(s[o]/255)*255;return i.putImageData(r,0,0),n}else if(t.data){let n=t.data.slice(0);for(let i=0;i<n.length;i++)n instanceof Uint8Array||n instanceof Uint8ClampedArray?n[i]=Math.floor(Er(n[i]/255)*255):n[i]=Er(n[i]);return{data:n,width:t.width,height:t.height}}else return Ft("ImageUtils.sRGBToLinear(): Unsupported image type. No color space conversion applied."),t}},K3=0,Ko=class{constructor(t=null){this.isTextureSource=!0,Object.defineProperty(this,"id",{value:K3++}),this.uuid=oa(),this.data=t,this.dataReady=!0,this.version=0}getSize(t){let n=this.data;return typeof HTMLVideoElement<"u"&&n instanceof HTMLVideoElement?t.set(n.videoWidth,n.videoHeight,0):typeof VideoFrame<"u"&&n instanceof VideoFrame?t.set(n.displayWidth,n.displayHeight,0):n!==null?t.set(n.width||0,n.height||0,n.depth||0):t.set(0,0,0),t}set needsUpdate(t){t===!0&&this.version++}toJSON(t){let n=t===void 0||typeof t=="string";if(!n&&t.images[this.uuid]!==void 0)return t.images[this.uuid];let i={uuid:this.uuid,url:""},r=this.data;if(r!==null){let s;if(Array.isArray(r)){s=[];for(let o=0,a=r.length;o<a;o++)r[o].isDataTexture?s.push(Tp(r[o].image)):s.push(Tp(r[o]))}else s=Tp(r);i.url=s}return n||(t.images[this.uuid]=i),i}};function Tp(e){return typeof HTMLImageElement<"u"&&e instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&e instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&e instanceof ImageBitmap?Hu.getDataURL(e):e.data?{data:Array.from(e.data),width:e.width,height:e.height,type:e.data.constructor.name}:(Ft("Texture: Unable to serialize Texture."),{})}var j3=0,Ap=new W,Fn=class e extends Xi{constructor(t=e.DEFAULT_IMAGE,n=e.DEFAULT_MAPPING,i=$i,r=$i,s=Mn,o=Pr,a=Pi,c=On,l=e.DEFAULT_ANISOTROPY,u=Nr){super(),this.isTexture=!0,Object.defineProperty(this,"id",{value:j3++}),this.uuid=oa(),this.name="",this.source=new Ko(t),this.mipmaps=[],this.mapping=n,this.channel=0,this.wrapS=i,this.wrapT=r,this.magFilter=s,this.minFilter=o,this.anisotropy=l,this.format=a,this.internalFormat=null,this.type=c,this.offset=new ie(0,0),this.repeat=new ie(1,1),this.center=new ie(0,0),this.rotation=0,this.matrixAutoUpdate=!0,this.matrix=new zt,this.generateMipmaps=!0,this.mipmapsAutoUpdate=!0,this.premultiplyAlpha=!1,this.flipY=!0,this.unpackAlignment=4,this.colorSpace=u,this.userData={},this.updateRanges=[],this.version=0,this.onUpdate=null,this.renderTarget=null,this.isRenderTargetTexture=!1,this.isArrayTexture=!!(t&&t.depth&&t.depth>1),this.pmremVersion=0,this.isPMREMTexture=!1,this.normalized=!1}get width(){return this.source.getSize(Ap).x}get height(){return this.source.getSize(Ap).y}get depth(){return this.source.getSize(Ap).z}get image(){return this.source.data}set image(t){this.source.data=t}updateMatrix(){this.matrix.setUvTransform(this.offset.x,this.offset.y,this.repeat.x,this.repeat.y,this.rotation,this.center.x,this.center.y)}addUpdateRange(t,n){this.updateRanges.push({start:t,count:n})}clearUpdateRanges(){this.updateRanges.length=0}clone(){return new this.constructor().copy(this)}copy(t){return this.name=t.name,this.source=t.source,this.mipmaps=t.mipmaps.slice(0),this.mapping=t.mapping,this.channel=t.channel,this.wrapS=t.wrapS,this.wrapT=t.wrapT,this.magFilter=t.magFilter,this.minFilter=t.minFilter,this.anisotropy=t.anisotropy,this.format=t.format,this.internalFormat=t.internalFormat,this.type=t.type,this.normalized=t.normalized,this.offset.copy(t.offset),this.repeat.copy(t.repeat),this.center.copy(t.center),this.rotation=t.rotation,this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrix.copy(t.matrix),this.generateMipmaps=t.generateMipmaps,this.mipmapsAutoUpdate=t.mipmapsAutoUpdate,this.premultiplyAlpha=t.premultiplyAlpha,this.flipY=t.flipY,this.unpackAlignment=t.unpackAlignment,this.colorSpace=t.colorSpace,this.renderTarget=t.renderTarget,this.isRenderTargetTexture=t.isRenderTargetTexture,this.isPMREMTexture=t.isPMREMTexture,this.isArrayTexture=t.isArrayTexture,this.userData=JSON.parse(JSON.stringify(t.userData)),this.needsUpdate=!0,this}setValues(t){for(let n in t){let i=t[n];if(i===void 0){Ft(`Texture.setValues(): parameter '${n}' has value of undefined.`);continue}let r=this[n];if(r===void 0){Ft(`Texture.setValues(): property '${n}' does not exist.`);continue}r&&i&&r.isVector2&&i.isVector2||r&&i&&r.isVector3&&i.isVector3||r&&i&&r.isMatrix3&&i.isMatrix3?r.copy(i):this[n]=i}}toJSON(t){let n=t===void 0||typeof t=="string";if(!n&&t.textures[this.uuid]!==void 0)return t.textures[this.uuid];let i={metadata:{version:4.7,type:"Texture",generator:"Texture.toJSON"},uuid:this.uuid,name:this.name,image:this.source.toJSON(t).uuid,mapping:this.mapping,channel:this.channel,repeat:[this.repeat.x,this.repeat.y],offset:[this.offset.x,this.offset.y],center:[this.center.x,this.center.y],rotation:this.rotation,wrap:[this.wrapS,this.wrapT],format:this.format,internalFormat:this.internalFormat,type:this.type,normalized:this.normalized,colorSpace:this.colorSpace,minFilter:this.minFilter,magFilter:this.magFilter,anisotropy:this.anisotropy,flipY:this.flipY,generateMipmaps:this.generateMipmaps,mipmapsAutoUpdate:this.mipmapsAutoUpdate,premultiplyAlpha:this.premultiplyAlpha,unpackAlignment:this.unpackAlignment};return Object.keys(this.userData).length>0&&(i.userData=this.userData),n||(t.textures[this.uuid]=i),i}dispose(){this.dispatchEvent({type:"dispose"})}transformUv(t){if(this.mapping!==lm)return t;if(t.applyMatrix3(this.matrix),t.x<0||t.x>1)switch(this.wrapS){case zu:t.x=t.x-Math.floor(t.x);break;case $i:t.x=t.x<0?0:1;break;case Gu:Math.abs(Math.floor(t.x)%2)===1?t.x=Math.ceil(t.x)-t.x:t.x=t.x-Math.floor(t.x);break}if(t.y<0||t.y>1)switch(this.wrapT){case zu:t.y=t.y-Math.floor(t.y);break;case $i:t.y=t.y<0?0:1;break;case Gu:Math.abs(Math.floor(t.y)%2)===1?t.y=Math.ceil(t.y)-t.y:t.y=t.y-Math.floor(t.y);break}return this.flipY&&(t.y=1-t.y),t}set needsUpdate(t){t===!0&&(this.version++,this.source.needsUpdate=!0)}set needsPMREMUpdate(t){t===!0&&this.pmremVersion++}};Fn.DEFAULT_IMAGE=null;Fn.DEFAULT_MAPPING=lm;Fn.DEFAULT_ANISOTROPY=1;var Te=class{static{this.prototype.isVector4=!0}constructor(t=0,n=0,i=0,r=1){this.x=t,this.y=n,this.z=i,this.w=r}get width(){return this.z}set width(t){this.z=t}get height(){return this.w}set height(t){this.w=t}set(t,n,i,r){return this.x=t,this.y=n,this.z=i,this.w=r,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this.w=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setW(t){return this.w=t,this}setComponent(t,n){switch(t){case 0:this.x=n;break;case 1:this.y=n;break;case 2:this.z=n;break;case 3:this.w=n;break;default:throw new Error("THREE.Vector4: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;case 3:return this.w;default:throw new Error("THREE.Vector4: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z,this.w)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this.w=t.w!==void 0?t.w:1,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this.w+=t.w,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this.w+=t,this}addVectors(t,n){return this.x=t.x+n.x,this.y=t.y+n.y,this.z=t.z+n.z,this.w=t.w+n.w,this}addScaledVector(t,n){return this.x+=t.x*n,this.y+=t.y*n,this.z+=t.z*n,this.w+=t.w*n,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this.w-=t.w,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this.w-=t,this}subVectors(t,n){return this.x=t.x-n.x,this.y=t.y-n.y,this.z=t.z-n.z,this.w=t.w-n.w,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this.w*=t.w,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this.w*=t,this}applyMatrix4(t){let n=this.x,i=this.y,r=this.z,s=this.w,o=t.elements;return this.x=o[0]*n+o[4]*i+o[8]*r+o[12]*s,this.y=o[1]*n+o[5]*i+o[9]*r+o[13]*s,this.z=o[2]*n+o[6]*i+o[10]*r+o[14]*s,this.w=o[3]*n+o[7]*i+o[11]*r+o[15]*s,this}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this.w/=t.w,this}divideScalar(t){return this.multiplyScalar(1/t)}setAxisAngleFromQuaternion(t){this.w=2*Math.acos(t.w);let n=Math.sqrt(1-t.w*t.w);return n<1e-4?(this.x=1,this.y=0,this.z=0):(this.x=t.x/n,this.y=t.y/n,this.z=t.z/n),this}setAxisAngleFromRotationMatrix(t){let n,i,r,s,c=t.elements,l=c[0],u=c[4],h=c[8],f=c[1],d=c[5],p=c[9],y=c[2],m=c[6],g=c[10];if(Math.abs(u-f)<.01&&Math.abs(h-y)<.01&&Math.abs(p-m)<.01){if(Math.abs(u+f)<.1&&Math.abs(h+y)<.1&&Math.abs(p+m)<.1&&Math.abs(l+d+g-3)<.1)return this.set(1,0,0,0),this;n=Math.PI;let S=(l+1)/2,_=(d+1)/2,w=(g+1)/2,b=(u+f)/4,x=(h+y)/4,M=(p+m)/4;return S>_&&S>w?S<.01?(i=0,r=.707106781,s=.707106781):(i=Math.sqrt(S),r=b/i,s=x/i):_>w?_<.01?(i=.707106781,r=0,s=.707106781):(r=Math.sqrt(_),i=b/r,s=M/r):w<.01?(i=.707106781,r=.707106781,s=0):(s=Math.sqrt(w),i=x/s,r=M/s),this.set(i,r,s,n),this}let v=Math.sqrt((m-p)*(m-p)+(h-y)*(h-y)+(f-u)*(f-u));return Math.abs(v)<.001&&(v=1),this.x=(m-p)/v,this.y=(h-y)/v,this.z=(f-u)/v,this.w=Math.acos((l+d+g-1)/2),this}setFromMatrixPosition(t){let n=t.elements;return this.x=n[12],this.y=n[13],this.z=n[14],this.w=n[15],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this.w=Math.min(this.w,t.w),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this.w=Math.max(this.w,t.w),this}clamp(t,n){return this.x=ne(this.x,t.x,n.x),this.y=ne(this.y,t.y,n.y),this.z=ne(this.z,t.z,n.z),this.w=ne(this.w,t.w,n.w),this}clampScalar(t,n){return this.x=ne(this.x,t,n),this.y=ne(this.y,t,n),this.z=ne(this.z,t,n),this.w=ne(this.w,t,n),this}clampLength(t,n){let i=this.length();return this.divideScalar(i||1).multiplyScalar(ne(i,t,n))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this.w=Math.floor(this.w),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this.w=Math.ceil(this.w),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this.w=Math.round(this.w),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this.w=Math.trunc(this.w),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this.w=-this.w,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z+this.w*t.w}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)+Math.abs(this.w)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,n){return this.x+=(t.x-this.x)*n,this.y+=(t.y-this.y)*n,this.z+=(t.z-this.z)*n,this.w+=(t.w-this.w)*n,this}lerpVectors(t,n,i){return this.x=t.x+(n.x-t.x)*i,this.y=t.y+(n.y-t.y)*i,this.z=t.z+(n.z-t.z)*i,this.w=t.w+(n.w-t.w)*i,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z&&t.w===this.w}fromArray(t,n=0){return this.x=t[n],this.y=t[n+1],this.z=t[n+2],this.w=t[n+3],this}toArray(t=[],n=0){return t[n]=this.x,t[n+1]=this.y,t[n+2]=this.z,t[n+3]=this.w,t}fromBufferAttribute(t,n){return this.x=t.getX(n),this.y=t.getY(n),this.z=t.getZ(n),this.w=t.getW(n),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this.w=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z,yield this.w}},Wu=class extends Xi{constructor(t=1,n=1,i={}){super(),i=Object.assign({generateMipmaps:!1,internalFormat:null,minFilter:Mn,depthBuffer:!0,stencilBuffer:!1,resolveColorBuffer:!0,resolveDepthBuffer:!0,resolveStencilBuffer:!0,storeMultisampledColorBuffer:!0,storeMultisampledDepthBuffer:!0,storeMultisampledStencilBuffer:!0,depthTexture:null,samples:0,count:1,depth:1,multiview:!1,useArrayDepthTexture:!1},i),this.isRenderTarget=!0,this.width=t,this.height=n,this.depth=i.depth,this.scissor=new Te(0,0,t,n),this.scissorTest=!1,this.viewport=new Te(0,0,t,n),this.textures=[];let r=i.count;for(let s=0;s<r;s++)this.textures[s]=new Fn({width:t,height:n,depth:i.depth}),this.textures[s].isRenderTargetTexture=!0,this.textures[s].renderTarget=this;this._setTextureOptions(i),this.depthBuffer=i.depthBuffer,this.stencilBuffer=i.stencilBuffer,this.resolveColorBuffer=i.resolveColorBuffer,this.resolveDepthBuffer=i.resolveDepthBuffer,this.resolveStencilBuffer=i.resolveStencilBuffer,this.storeMultisampledColorBuffer=i.storeMultisampledColorBuffer,this.storeMultisampledDepthBuffer=i.storeMultisampledDepthBuffer,this.storeMultisampledStencilBuffer=i.storeMultisampledStencilBuffer,this._depthTexture=null,this.depthTexture=i.depthTexture,this.samples=i.samples,this.multiview=i.multiview,this.useArrayDepthTexture=i.useArrayDepthTexture}_setTextureOptions(t={}){let n={minFilter:Mn,generateMipmaps:!1,flipY:!1,internalFormat:null};t.mapping!==void 0&&(n.mapping=t.mapping),t.wrapS!==void 0&&(n.wrapS=t.wrapS),t.wrapT!==void 0&&(n.wrapT=t.wrapT),t.wrapR!==void 0&&(n.wrapR=t.wrapR),t.magFilter!==void 0&&(n.magFilter=t.magFilter),t.minFilter!==void 0&&(n.minFilter=t.minFilter),t.format!==void 0&&(n.format=t.format),t.type!==void 0&&(n.type=t.type),t.anisotropy!==void 0&&(n.anisotropy=t.anisotropy),t.colorSpace!==void 0&&(n.colorSpace=t.colorSpace),t.flipY!==void 0&&(n.flipY=t.flipY),t.generateMipmaps!==void 0&&(n.generateMipmaps=t.generateMipmaps),t.mipmapsAutoUpdate!==void 0&&(n.mipmapsAutoUpdate=t.mipmapsAutoUpdate),t.internalFormat!==void 0&&(n.internalFormat=t.internalFormat);for(let i=0;i<this.textures.length;i++)this.textures[i].setValues(n)}get texture(){return this.textures[0]}set texture(t){this.textures[0]=t}set depthTexture(t){this._depthTexture!==null&&this._depthTexture.renderTarget===this&&(this._depthTexture.renderTarget=null),t!==null&&t.renderTarget===null&&(t.renderTarget=this),this._depthTexture=t}get depthTexture(){return this._depthTexture}setSize(t,n,i=1){if(this.width!==t||this.height!==n||this.depth!==i){this.width=t,this.height=n,this.depth=i;for(let r=0,s=this.textures.length;r<s;r++)this.textures[r].image.width=t,this.textures[r].image.height=n,this.textures[r].image.depth=i,this.textures[r].isData3DTexture!==!0&&(this.textures[r].isArrayTexture=this.textures[r].image.depth>1);this.dispose()}this.viewport.set(0,0,t,n),this.scissor.set(0,0,t,n)}clone(){return new this.constructor().copy(this)}copy(t){this.width=t.width,this.height=t.height,this.depth=t.depth,this.scissor.copy(t.scissor),this.scissorTest=t.scissorTest,this.viewport.copy(t.viewport),this.textures.length=0;for(let n=0,i=t.textures.length;n<i;n++){this.textures[n]=t.textures[n].clone(),this.textures[n].isRenderTargetTexture=!0,this.textures[n].renderTarget=this;let r=Object.assign({},t.textures[n].image);this.textures[n].source=new Ko(r)}if(this.depthBuffer=t.depthBuffer,this.stencilBuffer=t.stencilBuffer,this.resolveColorBuffer=t.resolveColorBuffer,this.resolveDepthBuffer=t.resolveDepthBuffer,this.resolveStencilBuffer=t.resolveStencilBuffer,this.storeMultisampledColorBuffer=t.storeMultisampledColorBuffer,this.storeMultisampledDepthBuffer=t.storeMultisampledDepthBuffer,this.storeMultisampledStencilBuffer=t.storeMultisampledStencilBuffer,t.depthTexture!==null)if(t.depthTexture.renderTarget===t){let n=t.depthTexture.clone();n.renderTarget=null,this.depthTexture=n}else this.depthTexture=t.depthTexture;else this.depthTexture=null;return this.samples=t.samples,this.multiview=t.multiview,this.useArrayDepthTexture=t.useArrayDepthTexture,this}dispose(){this.dispatchEvent({type:"dispose"})}},qn=class extends Wu{constructor(t=1,n=1,i={}){super(t,n,i),this.isWebGLRenderTarget=!0}},Sc=class extends Fn{constructor(t=null,n=1,i=1,r=1){super(null),this.isDataArrayTexture=!0,this.image={data:t,width:n,height:i,depth:r},this.magFilter=je,this.minFilter=je,this.wrapR=$i,this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1,this.layerUpdates=new Set}copy(t){return super.copy(t),this.wrapR=t.wrapR,this}addLayerUpdate(t){this.layerUpdates.add(t)}clearLayerUpdates(){this.layerUpdates.clear()}};var $u=class extends Fn{constructor(t=null,n=1,i=1,r=1){super(null),this.isData3DTexture=!0,this.image={data:t,width:n,height:i,depth:r},this.magFilter=je,this.minFilter=je,this.wrapR=$i,this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1}copy(t){return super.copy(t),this.wrapR=t.wrapR,this}};var we=class e{static{this.prototype.isMatrix4=!0}constructor(t,n,i,r,s,o,a,c,l,u,h,f,d,p,y,m){this.elements=[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],t!==void 0&&this.set(t,n,i,r,s,o,a,c,l,u,h,f,d,p,y,m)}set(t,n,i,r,s,o,a,c,l,u,h,f,d,p,y,m){let g=this.elements;return g[0]=t,g[4]=n,g[8]=i,g[12]=r,g[1]=s,g[5]=o,g[9]=a,g[13]=c,g[2]=l,g[6]=u,g[10]=h,g[14]=f,g[3]=d,g[7]=p,g[11]=y,g[15]=m,this}identity(){return this.set(1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1),this}clone(){return new e().fromArray(this.elements)}copy(t){let n=this.elements,i=t.elements;return n[0]=i[0],n[1]=i[1],n[2]=i[2],n[3]=i[3],n[4]=i[4],n[5]=i[5],n[6]=i[6],n[7]=i[7],n[8]=i[8],n[9]=i[9],n[10]=i[10],n[11]=i[11],n[12]=i[12],n[13]=i[13],n[14]=i[14],n[15]=i[15],this}copyPosition(t){let n=this.elements,i=t.elements;return n[12]=i[12],n[13]=i[13],n[14]=i[14],this}setFromMatrix3(t){let n=t.elements;return this.set(n[0],n[3],n[6],0,n[1],n[4],n[7],0,n[2],n[5],n[8],0,0,0,0,1),this}extractBasis(t,n,i){return this.determinantAffine()===0?(t.set(1,0,0),n.set(0,1,0),i.set(0,0,1),this):(t.setFromMatrixColumn(this,0),n.setFromMatrixColumn(this,1),i.setFromMatrixColumn(this,2),this)}makeBasis(t,n,i){return this.set(t.x,n.x,i.x,0,t.y,n.y,i.y,0,t.z,n.z,i.z,0,0,0,0,1),this}extractRotation(t){if(t.determinantAffine()===0)return this.identity();let n=this.elements,i=t.elements,r=1/Do.setFromMatrixColumn(t,0).length(),s=1/Do.setFromMatrixColumn(t,1).length(),o=1/Do.setFromMatrixColumn(t,2).length();return n[0]=i[0]*r,n[1]=i[1]*r,n[2]=i[2]*r,n[3]=0,n[4]=i[4]*s,n[5]=i[5]*s,n[6]=i[6]*s,n[7]=0,n[8]=i[8]*o,n[9]=i[9]*o,n[10]=i[10]*o,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,this}makeRotationFromEuler(t){let n=this.elements,i=t.x,r=t.y,s=t.z,o=Math.cos(i),a=Math.sin(i),c=Math.cos(r),l=Math.sin(r),u=Math.cos(s),h=Math.sin(s);if(t.order==="XYZ"){let f=o*u,d=o*h,p=a*u,y=a*h;n[0]=c*u,n[4]=-c*h,n[8]=l,n[1]=d+p*l,n[5]=f-y*l,n[9]=-a*c,n[2]=y-f*l,n[6]=p+d*l,n[10]=o*c}else if(t.order==="YXZ"){let f=c*u,d=c*h,p=l*u,y=l*h;n[0]=f+y*a,n[4]=p*a-d,n[8]=o*l,n[1]=o*h,n[5]=o*u,n[9]=-a,n[2]=d*a-p,n[6]=y+f*a,n[10]=o*c}else if(t.order==="ZXY"){let f=c*u,d=c*h,p=l*u,y=l*h;n[0]=f-y*a,n[4]=-o*h,n[8]=p+d*a,n[1]=d+p*a,n[5]=o*u,n[9]=y-f*a,n[2]=-o*l,n[6]=a,n[10]=o*c}else if(t.order==="ZYX"){let f=o*u,d=o*h,p=a*u,y=a*h;n[0]=c*u,n[4]=p*l-d,n[8]=f*l+y,n[1]=c*h,n[5]=y*l+f,n[9]=d*l-p,n[2]=-l,n[6]=a*c,n[10]=o*c}else if(t.order==="YZX"){let f=o*c,d=o*l,p=a*c,y=a*l;n[0]=c*u,n[4]=y-f*h,n[8]=p*h+d,n[1]=h,n[5]=o*u,n[9]=-a*u,n[2]=-l*u,n[6]=d*h+p,n[10]=f-y*h}else if(t.order==="XZY"){let f=o*c,d=o*l,p=a*c,y=a*l;n[0]=c*u,n[4]=-h,n[8]=l*u,n[1]=f*h+y,n[5]=o*u,n[9]=d*h-p,n[2]=p*h-d,n[6]=a*u,n[10]=y*h+f}return n[3]=0,n[7]=0,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,this}makeRotationFromQuaternion(t){return this.compose(Q3,t,tC)}lookAt(t,n,i){let r=this.elements;return Wn.subVectors(t,n),Wn.lengthSq()===0&&(Wn.z=1),Wn.normalize(),ss.crossVectors(i,Wn),ss.lengthSq()===0&&(Math.abs(i.z)===1?Wn.x+=1e-4:Wn.z+=1e-4,Wn.normalize(),ss.crossVectors(i,Wn)),ss.normalize(),fu.crossVectors(Wn,ss),r[0]=ss.x,r[4]=fu.x,r[8]=Wn.x,r[1]=ss.y,r[5]=fu.y,r[9]=Wn.y,r[2]=ss.z,r[6]=fu.z,r[10]=Wn.z,this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,n){let i=t.elements,r=n.elements,s=this.elements,o=i[0],a=i[4],c=i[8],l=i[12],u=i[1],h=i[5],f=i[9],d=i[13],p=i[2],y=i[6],m=i[10],g=i[14],v=i[3],S=i[7],_=i[11],w=i[15],b=r[0],x=r[4],M=r[8],R=r[12],E=r[1],C=r[5],N=r[9],B=r[13],I=r[2],L=r[6],k=r[10],F=r[14],Z=r[3],U=r[7],G=r[11],q=r[15];return s[0]=o*b+a*E+c*I+l*Z,s[4]=o*x+a*C+c*L+l*U,s[8]=o*M+a*N+c*k+l*G,s[12]=o*R+a*B+c*F+l*q,s[1]=u*b+h*E+f*I+d*Z,s[5]=u*x+h*C+f*L+d*U,s[9]=u*M+h*N+f*k+d*G,s[13]=u*R+h*B+f*F+d*q,s[2]=p*b+y*E+m*I+g*Z,s[6]=p*x+y*C+m*L+g*U,s[10]=p*M+y*N+m*k+g*G,s[14]=p*R+y*B+m*F+g*q,s[3]=v*b+S*E+_*I+w*Z,s[7]=v*x+S*C+_*L+w*U,s[11]=v*M+S*N+_*k+w*G,s[15]=v*R+S*B+_*F+w*q,this}multiplyScalar(t){let n=this.elements;return n[0]*=t,n[4]*=t,n[8]*=t,n[12]*=t,n[1]*=t,n[5]*=t,n[9]*=t,n[13]*=t,n[2]*=t,n[6]*=t,n[10]*=t,n[14]*=t,n[3]*=t,n[7]*=t,n[11]*=t,n[15]*=t,this}determinant(){let t=this.elements,n=t[0],i=t[4],r=t[8],s=t[12],o=t[1],a=t[5],c=t[9],l=t[13],u=t[2],h=t[6],f=t[10],d=t[14],p=t[3],y=t[7],m=t[11],g=t[15],v=c*d-l*f,S=a*d-l*h,_=a*f-c*h,w=o*d-l*u,b=o*f-c*u,x=o*h-a*u;return n*(y*v-m*S+g*_)-i*(p*v-m*w+g*b)+r*(p*S-y*w+g*x)-s*(p*_-y*b+m*x)}determinantAffine(){let t=this.elements,n=t[0],i=t[4],r=t[8],s=t[1],o=t[5],a=t[9],c=t[2],l=t[6],u=t[10];return n*(o*u-a*l)-i*(s*u-a*c)+r*(s*l-o*c)}transpose(){let t=this.elements,n;return n=t[1],t[1]=t[4],t[4]=n,n=t[2],t[2]=t[8],t[8]=n,n=t[6],t[6]=t[9],t[9]=n,n=t[3],t[3]=t[12],t[12]=n,n=t[7],t[7]=t[13],t[13]=n,n=t[11],t[11]=t[14],t[14]=n,this}setPosition(t,n,i){let r=this.elements;return t.isVector3?(r[12]=t.x,r[13]=t.y,r[14]=t.z):(r[12]=t,r[13]=n,r[14]=i),this}invert(){let t=this.elements,n=t[0],i=t[1],r=t[2],s=t[3],o=t[4],a=t[5],c=t[6],l=t[7],u=t[8],h=t[9],f=t[10],d=t[11],p=t[12],y=t[13],m=t[14],g=t[15],v=n*a-i*o,S=n*c-r*o,_=n*l-s*o,w=i*c-r*a,b=i*l-s*a,x=r*l-s*c,M=u*y-h*p,R=u*m-f*p,E=u*g-d*p,C=h*m-f*y,N=h*g-d*y,B=f*g-d*m,I=v*B-S*N+_*C+w*E-b*R+x*M;if(I===0)return this.set(0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0);let L=1/I;return t[0]=(a*B-c*N+l*C)*L,t[1]=(r*N-i*B-s*C)*L,t[2]=(y*x-m*b+g*w)*L,t[3]=(f*b-h*x-d*w)*L,t[4]=(c*E-o*B-l*R)*L,t[5]=(n*B-r*E+s*R)*L,t[6]=(m*_-p*x-g*S)*L,t[7]=(u*x-f*_+d*S)*L,t[8]=(o*N-a*E+l*M)*L,t[9]=(i*E-n*N-s*M)*L,t[10]=(p*b-y*_+g*v)*L,t[11]=(h*_-u*b-d*v)*L,t[12]=(a*R-o*C-c*M)*L,t[13]=(n*C-i*R+r*M)*L,t[14]=(y*S-p*w-m*v)*L,t[15]=(u*w-h*S+f*v)*L,this}scale(t){let n=this.elements,i=t.x,r=t.y,s=t.z;return n[0]*=i,n[4]*=r,n[8]*=s,n[1]*=i,n[5]*=r,n[9]*=s,n[2]*=i,n[6]*=r,n[10]*=s,n[3]*=i,n[7]*=r,n[11]*=s,this}getMaxScaleOnAxis(){let t=this.elements,n=t[0]*t[0]+t[1]*t[1]+t[2]*t[2],i=t[4]*t[4]+t[5]*t[5]+t[6]*t[6],r=t[8]*t[8]+t[9]*t[9]+t[10]*t[10];return Math.sqrt(Math.max(n,i,r))}makeTranslation(t,n,i){return t.isVector3?this.set(1,0,0,t.x,0,1,0,t.y,0,0,1,t.z,0,0,0,1):this.set(1,0,0,t,0,1,0,n,0,0,1,i,0,0,0,1),this}makeRotationX(t){let n=Math.cos(t),i=Math.sin(t);return this.set(1,0,0,0,0,n,-i,0,0,i,n,0,0,0,0,1),this}makeRotationY(t){let n=Math.cos(t),i=Math.sin(t);return this.set(n,0,i,0,0,1,0,0,-i,0,n,0,0,0,0,1),this}makeRotationZ(t){let n=Math.cos(t),i=Math.sin(t);return this.set(n,-i,0,0,i,n,0,0,0,0,1,0,0,0,0,1),this}makeRotationAxis(t,n){let i=Math.cos(n),r=Math.sin(n),s=1-i,o=t.x,a=t.y,c=t.z,l=s*o,u=s*a;return this.set(l*o+i,l*a-r*c,l*c+r*a,0,l*a+r*c,u*a+i,u*c-r*o,0,l*c-r*a,u*c+r*o,s*c*c+i,0,0,0,0,1),this}makeScale(t,n,i){return this.set(t,0,0,0,0,n,0,0,0,0,i,0,0,0,0,1),this}makeShear(t,n,i,r,s,o){return this.set(1,i,s,0,t,1,o,0,n,r,1,0,0,0,0,1),this}compose(t,n,i){let r=this.elements,s=n._x,o=n._y,a=n._z,c=n._w,l=s+s,u=o+o,h=a+a,f=s*l,d=s*u,p=s*h,y=o*u,m=o*h,g=a*h,v=c*l,S=c*u,_=c*h,w=i.x,b=i.y,x=i.z;return r[0]=(1-(y+g))*w,r[1]=(d+_)*w,r[2]=(p-S)*w,r[3]=0,r[4]=(d-_)*b,r[5]=(1-(f+g))*b,r[6]=(m+v)*b,r[7]=0,r[8]=(p+S)*x,r[9]=(m-v)*x,r[10]=(1-(f+y))*x,r[11]=0,r[12]=t.x,r[13]=t.y,r[14]=t.z,r[15]=1,this}decompose(t,n,i){let r=this.elements;t.x=r[12],t.y=r[13],t.z=r[14];let s=this.determinantAffine();if(s===0)return i.set(1,1,1),n.identity(),this;let o=Do.set(r[0],r[1],r[2]).length(),a=Do.set(r[4],r[5],r[6]).length(),c=Do.set(r[8],r[9],r[10]).length();s<0&&(o=-o),wi.copy(this);let l=1/o,u=1/a,h=1/c;return wi.elements[0]*=l,wi.elements[1]*=l,wi.elements[2]*=l,wi.elements[4]*=u,wi.elements[5]*=u,wi.elements[6]*=u,wi.elements[8]*=h,wi.elements[9]*=h,wi.elements[10]*=h,n.setFromRotationMatrix(wi),i.x=o,i.y=a,i.z=c,this}makePerspective(t,n,i,r,s,o,a=ii,c=!1){let l=this.elements,u=2*s/(n-t),h=2*s/(i-r),f=(n+t)/(n-t),d=(i+r)/(i-r),p,y;if(c)p=s/(o-s),y=o*s/(o-s);else if(a===ii)p=-(o+s)/(o-s),y=-2*o*s/(o-s);else if(a===Yo)p=-o/(o-s),y=-o*s/(o-s);else throw new Error("THREE.Matrix4.makePerspective(): Invalid coordinate system: "+a);return l[0]=u,l[4]=0,l[8]=f,l[12]=0,l[1]=0,l[5]=h,l[9]=d,l[13]=0,l[2]=0,l[6]=0,l[10]=p,l[14]=y,l[3]=0,l[7]=0,l[11]=-1,l[15]=0,this}makeOrthographic(t,n,i,r,s,o,a=ii,c=!1){let l=this.elements,u=2/(n-t),h=2/(i-r),f=-(n+t)/(n-t),d=-(i+r)/(i-r),p,y;if(c)p=1/(o-s),y=o/(o-s);else if(a===ii)p=-2/(o-s),y=-(o+s)/(o-s);else if(a===Yo)p=-1/(o-s),y=-s/(o-s);else throw new Error("THREE.Matrix4.makeOrthographic(): Invalid coordinate system: "+a);return l[0]=u,l[4]=0,l[8]=0,l[12]=f,l[1]=0,l[5]=h,l[9]=0,l[13]=d,l[2]=0,l[6]=0,l[10]=p,l[14]=y,l[3]=0,l[7]=0,l[11]=0,l[15]=1,this}equals(t){let n=this.elements,i=t.elements;for(let r=0;r<16;r++)if(n[r]!==i[r])return!1;return!0}fromArray(t,n=0){for(let i=0;i<16;i++)this.elements[i]=t[i+n];return this}toArray(t=[],n=0){let i=this.elements;return t[n]=i[0],t[n+1]=i[1],t[n+2]=i[2],t[n+3]=i[3],t[n+4]=i[4],t[n+5]=i[5],t[n+6]=i[6],t[n+7]=i[7],t[n+8]=i[8],t[n+9]=i[9],t[n+10]=i[10],t[n+11]=i[11],t[n+12]=i[12],t[n+13]=i[13],t[n+14]=i[14],t[n+15]=i[15],t}},Do=new W,wi=new we,Q3=new W(0,0,0),tC=new W(1,1,1),ss=new W,fu=new W,Wn=new W,rv=new we,sv=new Sn,Rr=class e{constructor(t=0,n=0,i=0,r=e.DEFAULT_ORDER){this.isEuler=!0,this._x=t,this._y=n,this._z=i,this._order=r}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get order(){return this._order}set order(t){this._order=t,this._onChangeCallback()}set(t,n,i,r=this._order){return this._x=t,this._y=n,this._z=i,this._order=r,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._order)}copy(t){return this._x=t._x,this._y=t._y,this._z=t._z,this._order=t._order,this._onChangeCallback(),this}setFromRotationMatrix(t,n=this._order,i=!0){let r=t.elements,s=r[0],o=r[4],a=r[8],c=r[1],l=r[5],u=r[9],h=r[2],f=r[6],d=r[10];switch(n){case"XYZ":this._y=Math.asin(ne(a,-1,1)),Math.abs(a)<.9999999?(this._x=Math.atan2(-u,d),this._z=Math.atan2(-o,s)):(this._x=Math.atan2(f,l),this._z=0);break;case"YXZ":this._x=Math.asin(-ne(u,-1,1)),Math.abs(u)<.9999999?(this._y=Math.atan2(a,d),this._z=Math.atan2(c,l)):(this._y=Math.atan2(-h,s),this._z=0);break;case"ZXY":this._x=Math.asin(ne(f,-1,1)),Math.abs(f)<.9999999?(this._y=Math.atan2(-h,d),this._z=Math.atan2(-o,l)):(this._y=0,this._z=Math.atan2(c,s));break;case"ZYX":this._y=Math.asin(-ne(h,-1,1)),Math.abs(h)<.9999999?(this._x=Math.atan2(f,d),this._z=Math.atan2(c,s)):(this._x=0,this._z=Math.atan2(-o,l));break;case"YZX":this._z=Math.asin(ne(c,-1,1)),Math.abs(c)<.9999999?(this._x=Math.atan2(-u,l),this._y=Math.atan2(-h,s)):(this._x=0,this._y=Math.atan2(a,d));break;case"XZY":this._z=Math.asin(-ne(o,-1,1)),Math.abs(o)<.9999999?(this._x=Math.atan2(f,l),this._y=Math.atan2(a,s)):(this._x=Math.atan2(-u,d),this._y=0);break;default:Ft("Euler: .setFromRotationMatrix() encountered an unknown order: "+n)}return this._order=n,i===!0&&this._onChangeCallback(),this}setFromQuaternion(t,n,i){return rv.makeRotationFromQuaternion(t),this.setFromRotationMatrix(rv,n,i)}setFromVector3(t,n=this._order){return this.set(t.x,t.y,t.z,n)}reorder(t){return sv.setFromEuler(this),this.setFromQuaternion(sv,t)}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._order===this._order}fromArray(t){return this._x=t[0],this._y=t[1],this._z=t[2],t[3]!==void 0&&(this._order=t[3]),this._onChangeCallback(),this}toArray(t=[],n=0){return t[n]=this._x,t[n+1]=this._y,t[n+2]=this._z,t[n+3]=this._order,t}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._order}};Rr.DEFAULT_ORDER="XYZ";var wc=class{constructor(){this.mask=1}set(t){this.mask=(1<<t|0)>>>0}enable(t){this.mask|=1<<t|0}enableAll(){this.mask=-1}toggle(t){this.mask^=1<<t|0}disable(t){this.mask&=~(1<<t|0)}disableAll(){this.mask=0}test(t){return(this.mask&t.mask)!==0}isEnabled(t){return(this.mask&(1<<t|0))!==0}},eC=0,ov=new W,Fo=new Sn,br=new we,hu=new W,hc=new W,nC=new W,iC=new Sn,av=new W(1,0,0),cv=new W(0,1,0),lv=new W(0,0,1),uv={type:"added"},rC={type:"removed"},Uo={type:"childadded",child:null},Ep={type:"childremoved",child:null},wn=class e extends Xi{constructor(){super(),this.isObject3D=!0,Object.defineProperty(this,"id",{value:eC++}),this.uuid=oa(),this.name="",this.type="Object3D",this.parent=null,this.children=[],this.up=e.DEFAULT_UP.clone();let t=new W,n=new Rr,i=new Sn,r=new W(1,1,1);function s(){i.setFromEuler(n,!1)}function o(){n.setFromQuaternion(i,void 0,!1)}n._onChange(s),i._onChange(o),Object.defineProperties(this,{position:{configurable:!0,enumerable:!0,value:t},rotation:{configurable:!0,enumerable:!0,value:n},quaternion:{configurable:!0,enumerable:!0,value:i},scale:{configurable:!0,enumerable:!0,value:r},modelViewMatrix:{value:new we},normalMatrix:{value:new zt}}),this.matrix=new we,this.matrixWorld=new we,this.matrixAutoUpdate=e.DEFAULT_MATRIX_AUTO_UPDATE,this.matrixWorldAutoUpdate=e.DEFAULT_MATRIX_WORLD_AUTO_UPDATE,this.matrixWorldNeedsUpdate=!1,this.layers=new wc,this.visible=!0,this.castShadow=!1,this.receiveShadow=!1,this.frustumCulled=!0,this.renderOrder=0,this.animations=[],this.customDepthMaterial=void 0,this.customDistanceMaterial=void 0,this.static=!1,this.userData={},this.pivot=null}onBeforeShadow(){}onAfterShadow(){}onBeforeRender(){}onAfterRender(){}applyMatrix4(t){this.matrixAutoUpdate&&this.updateMatrix(),this.matrix.premultiply(t),this.matrix.decompose(this.position,this.quaternion,this.scale),this.pivot!==null&&this.position.copy(this.pivot).applyMatrix4(this.matrix).sub(this.pivot)}applyQuaternion(t){return this.quaternion.premultiply(t),this}setRotationFromAxisAngle(t,n){this.quaternion.setFromAxisAngle(t,n)}setRotationFromEuler(t){this.quaternion.setFromEuler(t,!0)}setRotationFromMatrix(t){this.quaternion.setFromRotationMatrix(t)}setRotationFromQuaternion(t){this.quaternion.copy(t)}rotateOnAxis(t,n){return Fo.setFromAxisAngle(t,n),this.quaternion.multiply(Fo),this}rotateOnWorldAxis(t,n){return Fo.setFromAxisAngle(t,n),this.quaternion.premultiply(Fo),this}rotateX(t){return this.rotateOnAxis(av,t)}rotateY(t){return this.rotateOnAxis(cv,t)}rotateZ(t){return this.rotateOnAxis(lv,t)}translateOnAxis(t,n){return ov.copy(t).applyQuaternion(this.quaternion),this.position.add(ov.multiplyScalar(n)),this}translateX(t){return this.translateOnAxis(av,t)}translateY(t){return this.translateOnAxis(cv,t)}translateZ(t){return this.translateOnAxis(lv,t)}localToWorld(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(this.matrixWorld)}worldToLocal(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(br.copy(this.matrixWorld).invert())}lookAt(t,n,i){t.isVector3?hu.copy(t):hu.set(t,n,i);let r=this.parent;this.updateWorldMatrix(!0,!1),hc.setFromMatrixPosition(this.matrixWorld),this.isCamera||this.isLight?br.lookAt(hc,hu,this.up):br.lookAt(hu,hc,this.up),this.quaternion.setFromRotationMatrix(br),r&&(br.extractRotation(r.matrixWorld),Fo.setFromRotationMatrix(br),this.quaternion.premultiply(Fo.invert()))}add(t){if(arguments.length>1){for(let n=0;n<arguments.length;n++)this.add(arguments[n]);return this}return t===this?(kt("Object3D.add: object can't be added as a child of itself.",t),this):(t&&t.isObject3D?(t.removeFromParent(),t.parent=this,this.children.push(t),t.dispatchEvent(uv),Uo.child=t,this.dispatchEvent(Uo),Uo.child=null):kt("Object3D.add: object not an instance of THREE.Object3D.",t),this)}remove(t){if(arguments.length>1){for(let i=0;i<arguments.length;i++)this.remove(arguments[i]);return this}let n=this.children.indexOf(t);return n!==-1&&(t.parent=null,this.children.splice(n,1),t.dispatchEvent(rC),Ep.child=t,this.dispatchEvent(Ep),Ep.child=null),this}removeFromParent(){let t=this.parent;return t!==null&&t.remove(this),this}clear(){return this.remove(...this.children)}attach(t){return this.updateWorldMatrix(!0,!1),br.copy(this.matrixWorld).invert(),t.parent!==null&&(t.parent.updateWorldMatrix(!0,!1),br.multiply(t.parent.matrixWorld)),t.applyMatrix4(br),t.removeFromParent(),t.parent=this,this.children.push(t),t.updateWorldMatrix(!1,!0),t.dispatchEvent(uv),Uo.child=t,this.dispatchEvent(Uo),Uo.child=null,this}getObjectById(t){return this.getObjectByProperty("id",t)}getObjectByName(t){return this.getObjectByProperty("name",t)}getObjectByProperty(t,n){if(this[t]===n)return this;for(let i=0,r=this.children.length;i<r;i++){let o=this.children[i].getObjectByProperty(t,n);if(o!==void 0)return o}}getObjectsByProperty(t,n,i=[]){this[t]===n&&i.push(this);let r=this.children;for(let s=0,o=r.length;s<o;s++)r[s].getObjectsByProperty(t,n,i);return i}getWorldPosition(t){return this.updateWorldMatrix(!0,!1),t.setFromMatrixPosition(this.matrixWorld)}getWorldQuaternion(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(hc,t,nC),t}getWorldScale(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(hc,iC,t),t}getWorldDirection(t){this.updateWorldMatrix(!0,!1);let n=this.matrixWorld.elements;return t.set(n[8],n[9],n[10]).normalize()}raycast(){}intersectsFrustum(){return!0}traverse(t){t(this);let n=this.children;for(let i=0,r=n.length;i<r;i++)n[i].traverse(t)}traverseVisible(t){if(this.visible===!1)return;t(this);let n=this.children;for(let i=0,r=n.length;i<r;i++)n[i].traverseVisible(t)}traverseAncestors(t){let n=this.parent;n!==null&&(t(n),n.traverseAncestors(t))}updateMatrix(){this.matrix.compose(this.position,this.quaternion,this.scale);let t=this.pivot;if(t!==null){let n=t.x,i=t.y,r=t.z,s=this.matrix.elements;s[12]+=n-s[0]*n-s[4]*i-s[8]*r,s[13]+=i-s[1]*n-s[5]*i-s[9]*r,s[14]+=r-s[2]*n-s[6]*i-s[10]*r}this.matrixWorldNeedsUpdate=!0}updateMatrixWorld(t){this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||t)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,t=!0);let n=this.children;for(let i=0,r=n.length;i<r;i++)n[i].updateMatrixWorld(t)}updateWorldMatrix(t,n,i=!1){let r=this.parent;if(t===!0&&r!==null&&r.updateWorldMatrix(!0,!1),this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||i)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,i=!0),n===!0){let s=this.children;for(let o=0,a=s.length;o<a;o++)s[o].updateWorldMatrix(!1,!0,i)}}toJSON(t){let n=t===void 0||typeof t=="string",i={};n&&(t={geometries:{},materials:{},textures:{},images:{},shapes:{},skeletons:{},animations:{},nodes:{}},i.metadata={version:4.7,type:"Object",generator:"Object3D.toJSON"});let r={};r.uuid=this.uuid,r.type=this.type,r.name=this.name,r.castShadow=this.castShadow,r.receiveShadow=this.receiveShadow,r.visible=this.visible,r.frustumCulled=this.frustumCulled,r.renderOrder=this.renderOrder,r.static=this.static,r.matrixAutoUpdate=this.matrixAutoUpdate,Object.keys(this.userData).length>0&&(r.userData=this.userData),r.layers=this.layers.mask,r.matrix=this.matrix.toArray(),r.up=this.up.toArray(),this.pivot!==null&&(r.pivot=this.pivot.toArray()),this.morphTargetDictionary!==void 0&&(r.morphTargetDictionary=Object.assign({},this.morphTargetDictionary)),this.morphTargetInfluences!==void 0&&(r.morphTargetInfluences=this.morphTargetInfluences.slice()),this.isInstancedMesh&&(r.type="InstancedMesh",r.count=this.count,r.instanceMatrix=this.instanceMatrix.toJSON(),this.instanceColor!==null&&(r.instanceColor=this.instanceColor.toJSON())),this.isBatchedMesh&&(r.type="BatchedMesh",r.perObjectFrustumCulled=this.perObjectFrustumCulled,r.sortObjects=this.sortObjects,r.drawRanges=this._drawRanges,r.reservedRanges=this._reservedRanges,r.geometryInfo=this._geometryInfo.map(a=>({...a,boundingBox:a.boundingBox?a.boundingBox.toJSON():void 0,boundingSphere:a.boundingSphere?a.boundingSphere.toJSON():void 0})),r.instanceInfo=this._instanceInfo.map(a=>({...a})),r.availableInstanceIds=this._availableInstanceIds.slice(),r.availableGeometryIds=this._availableGeometryIds.slice(),r.nextIndexStart=this._nextIndexStart,r.nextVertexStart=this._nextVertexStart,r.geometryCount=this._geometryCount,r.maxInstanceCount=this._maxInstanceCount,r.maxVertexCount=this._maxVertexCount,r.maxIndexCount=this._maxIndexCount,r.geometryInitialized=this._geometryInitialized,r.matricesTexture=this._matricesTexture.toJSON(t),r.indirectTexture=this._indirectTexture.toJSON(t),this._colorsTexture!==null&&(r.colorsTexture=this._colorsTexture.toJSON(t)),this.boundingSphere!==null&&(r.boundingSphere=this.boundingSphere.toJSON()),this.boundingBox!==null&&(r.boundingBox=this.boundingBox.toJSON()));function s(a,c){return a[c.uuid]===void 0&&(a[c.uuid]=c.toJSON(t)),c.uuid}if(this.isScene)this.background&&(this.background.isColor?r.background=this.background.toJSON():this.background.isTexture&&(r.background=this.background.toJSON(t).uuid)),this.environment&&this.environment.isTexture&&this.environment.isRenderTargetTexture!==!0&&(r.environment=this.environment.toJSON(t).uuid);else if(this.isMesh||this.isLine||this.isPoints){r.geometry=s(t.geometries,this.geometry);let a=this.geometry.parameters;if(a!==void 0&&a.shapes!==void 0){let c=a.shapes;if(Array.isArray(c))for(let l=0,u=c.length;l<u;l++){let h=c[l];s(t.shapes,h)}else s(t.shapes,c)}}if(this.isSkinnedMesh&&(r.bindMode=this.bindMode,r.bindMatrix=this.bindMatrix.toArray(),this.skeleton!==void 0&&(s(t.skeletons,this.skeleton),r.skeleton=this.skeleton.uuid)),this.material!==void 0)if(Array.isArray(this.material)){let a=[];for(let c=0,l=this.material.length;c<l;c++)a.push(s(t.materials,this.material[c]));r.material=a}else r.material=s(t.materials,this.material);if(this.children.length>0){r.children=[];for(let a=0;a<this.children.length;a++)r.children.push(this.children[a].toJSON(t).object)}if(this.animations.length>0){r.animations=[];for(let a=0;a<this.animations.length;a++){let c=this.animations[a];r.animations.push(s(t.animations,c))}}if(n){let a=o(t.geometries),c=o(t.materials),l=o(t.textures),u=o(t.images),h=o(t.shapes),f=o(t.skeletons),d=o(t.animations),p=o(t.nodes);a.length>0&&(i.geometries=a),c.length>0&&(i.materials=c),l.length>0&&(i.textures=l),u.length>0&&(i.images=u),h.length>0&&(i.shapes=h),f.length>0&&(i.skeletons=f),d.length>0&&(i.animations=d),p.length>0&&(i.nodes=p)}return i.object=r,i;function o(a){let c=[];for(let l in a){let u=a[l];delete u.metadata,c.push(u)}return c}}clone(t){return new this.constructor().copy(this,t)}copy(t,n=!0){if(this.name=t.name,this.up.copy(t.up),this.position.copy(t.position),this.rotation.order=t.rotation.order,this.quaternion.copy(t.quaternion),this.scale.copy(t.scale),this.pivot=t.pivot!==null?t.pivot.clone():null,this.matrix.copy(t.matrix),this.matrixWorld.copy(t.matrixWorld),this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrixWorldAutoUpdate=t.matrixWorldAutoUpdate,this.matrixWorldNeedsUpdate=t.matrixWorldNeedsUpdate,this.layers.mask=t.layers.mask,this.visible=t.visible,this.castShadow=t.castShadow,this.receiveShadow=t.receiveShadow,this.frustumCulled=t.frustumCulled,this.renderOrder=t.renderOrder,this.static=t.static,this.animations=t.animations.slice(),this.userData=JSON.parse(JSON.stringify(t.userData)),n===!0)for(let i=0;i<t.children.length;i++){let r=t.children[i];this.add(r.clone())}return this}dispose(){this.dispatchEvent({type:"dispose"})}};wn.DEFAULT_UP=new W(0,1,0);wn.DEFAULT_MATRIX_AUTO_UPDATE=!0;wn.DEFAULT_MATRIX_WORLD_AUTO_UPDATE=!0;var Ar=class extends wn{constructor(){super(),this.isGroup=!0,this.type="Group"}},sC={type:"move"},jo=class{constructor(){this._targetRay=null,this._grip=null,this._hand=null}getHandSpace(){return this._hand===null&&(this._hand=new Ar,this._hand.matrixAutoUpdate=!1,this._hand.visible=!1,this._hand.joints={},this._hand.inputState={pinching:!1}),this._hand}getTargetRaySpace(){return this._targetRay===null&&(this._targetRay=new Ar,this._targetRay.matrixAutoUpdate=!1,this._targetRay.visible=!1,this._targetRay.hasLinearVelocity=!1,this._targetRay.linearVelocity=new W,this._targetRay.hasAngularVelocity=!1,this._targetRay.angularVelocity=new W),this._targetRay}getGripSpace(){return this._grip===null&&(this._grip=new Ar,this._grip.matrixAutoUpdate=!1,this._grip.visible=!1,this._grip.hasLinearVelocity=!1,this._grip.linearVelocity=new W,this._grip.hasAngularVelocity=!1,this._grip.angularVelocity=new W,this._grip.eventsEnabled=!1),this._grip}dispatchEvent(t){return this._targetRay!==null&&this._targetRay.dispatchEvent(t),this._grip!==null&&this._grip.dispatchEvent(t),this._hand!==null&&this._hand.dispatchEvent(t),this}connect(t){if(t&&t.hand){let n=this._hand;if(n)for(let i of t.hand.values())this._getHandJoint(n,i)}return this.dispatchEvent({type:"connected",data:t}),this}disconnect(t){return this.dispatchEvent({type:"disconnected",data:t}),this._targetRay!==null&&(this._targetRay.visible=!1),this._grip!==null&&(this._grip.visible=!1),this._hand!==null&&(this._hand.visible=!1),this}update(t,n,i){let r=null,s=null,o=null,a=this._targetRay,c=this._grip,l=this._hand;if(t&&n.session.visibilityState!=="visible-blurred"){if(l&&t.hand){o=!0;for(let y of t.hand.values()){let m=n.getJointPose(y,i),g=this._getHandJoint(l,y);m!==null&&(g.matrix.fromArray(m.transform.matrix),g.matrix.decompose(g.position,g.quaternion,g.scale),g.matrixWorldNeedsUpdate=!0,g.jointRadius=m.radius),g.visible=m!==null}let u=l.joints["index-finger-tip"],h=l.joints["thumb-tip"],f=u.position.distanceTo(h.position),d=.02,p=.005;l.inputState.pinching&&f>d+p?(l.inputState.pinching=!1,this.dispatchEvent({type:"pinchend",handedness:t.handedness,target:this})):!l.inputState.pinching&&f<=d-p&&(l.inputState.pinching=!0,this.dispatchEvent({type:"pinchstart",handedness:t.handedness,target:this}))}else c!==null&&t.gripSpace&&(s=n.getPose(t.gripSpace,i),s!==null&&(c.matrix.fromArray(s.transform.matrix),c.matrix.decompose(c.position,c.quaternion,c.scale),c.matrixWorldNeedsUpdate=!0,s.linearVelocity?(c.hasLinearVelocity=!0,c.linearVelocity.copy(s.linearVelocity)):c.hasLinearVelocity=!1,s.angularVelocity?(c.hasAngularVelocity=!0,c.angularVelocity.copy(s.angularVelocity)):c.hasAngularVelocity=!1,c.eventsEnabled&&c.dispatchEvent({type:"gripUpdated",data:t,target:this})));a!==null&&(r=n.getPose(t.targetRaySpace,i),r===null&&s!==null&&(r=s),r!==null&&(a.matrix.fromArray(r.transform.matrix),a.matrix.decompose(a.position,a.quaternion,a.scale),a.matrixWorldNeedsUpdate=!0,r.linearVelocity?(a.hasLinearVelocity=!0,a.linearVelocity.copy(r.linearVelocity)):a.hasLinearVelocity=!1,r.angularVelocity?(a.hasAngularVelocity=!0,a.angularVelocity.copy(r.angularVelocity)):a.hasAngularVelocity=!1,this.dispatchEvent(sC)))}return a!==null&&(a.visible=r!==null),c!==null&&(c.visible=s!==null),l!==null&&(l.visible=o!==null),this}_getHandJoint(t,n){if(t.joints[n.jointName]===void 0){let i=new Ar;i.matrixAutoUpdate=!1,i.visible=!1,t.joints[n.jointName]=i,t.add(i)}return t.joints[n.jointName]}},cb={aliceblue:15792383,antiquewhite:16444375,aqua:65535,aquamarine:8388564,azure:15794175,beige:16119260,bisque:16770244,black:0,blanchedalmond:16772045,blue:255,blueviolet:9055202,brown:10824234,burlywood:14596231,cadetblue:6266528,chartreuse:8388352,chocolate:13789470,coral:16744272,cornflowerblue:6591981,cornsilk:16775388,crimson:14423100,cyan:65535,darkblue:139,darkcyan:35723,darkgoldenrod:12092939,darkgray:11119017,darkgreen:25600,darkgrey:11119017,darkkhaki:12433259,darkmagenta:9109643,darkolivegreen:5597999,darkorange:16747520,darkorchid:10040012,darkred:9109504,darksalmon:15308410,darkseagreen:9419919,darkslateblue:4734347,darkslategray:3100495,darkslategrey:3100495,darkturquoise:52945,darkviolet:9699539,deeppink:16716947,deepskyblue:49151,dimgray:6908265,dimgrey:6908265,dodgerblue:2003199,firebrick:11674146,floralwhite:16775920,forestgreen:2263842,fuchsia:16711935,gainsboro:14474460,ghostwhite:16316671,gold:16766720,goldenrod:14329120,gray:8421504,green:32768,greenyellow:11403055,grey:8421504,honeydew:15794160,hotpink:16738740,indianred:13458524,indigo:4915330,ivory:16777200,khaki:15787660,lavender:15132410,lavenderblush:16773365,lawngreen:8190976,lemonchiffon:16775885,lightblue:11393254,lightcoral:15761536,lightcyan:14745599,lightgoldenrodyellow:16448210,lightgray:13882323,lightgreen:9498256,lightgrey:13882323,lightpink:16758465,lightsalmon:16752762,lightseagreen:2142890,lightskyblue:8900346,lightslategray:7833753,lightslategrey:7833753,lightsteelblue:11584734,lightyellow:16777184,lime:65280,limegreen:3329330,linen:16445670,magenta:16711935,maroon:8388608,mediumaquamarine:6737322,mediumblue:205,mediumorchid:12211667,mediumpurple:9662683,mediumseagreen:3978097,mediumslateblue:8087790,mediumspringgreen:64154,mediumturquoise:4772300,mediumvioletred:13047173,midnightblue:1644912,mintcream:16121850,mistyrose:16770273,moccasin:16770229,navajowhite:16768685,navy:128,oldlace:16643558,olive:8421376,olivedrab:7048739,orange:16753920,orangered:16729344,orchid:14315734,palegoldenrod:15657130,palegreen:10025880,paleturquoise:11529966,palevioletred:14381203,papayawhip:16773077,peachpuff:16767673,peru:13468991,pink:16761035,plum:14524637,powderblue:11591910,purple:8388736,rebeccapurple:6697881,red:16711680,rosybrown:12357519,royalblue:4286945,saddlebrown:9127187,salmon:16416882,sandybrown:16032864,seagreen:3050327,seashell:16774638,sienna:10506797,silver:12632256,skyblue:8900331,slateblue:6970061,slategray:7372944,slategrey:7372944,snow:16775930,springgreen:65407,steelblue:4620980,tan:13808780,teal:32896,thistle:14204888,tomato:16737095,turquoise:4251856,violet:15631086,wheat:16113331,white:16777215,whitesmoke:16119285,yellow:16776960,yellowgreen:10145074},os={h:0,s:0,l:0},du={h:0,s:0,l:0};function Cp(e,t,n){return n<0&&(n+=1),n>1&&(n-=1),n<1/6?e+(t-e)*6*n:n<1/2?t:n<2/3?e+(t-e)*6*(2/3-n):e}var Zt=class{constructor(t,n,i){return this.isColor=!0,this.r=1,this.g=1,this.b=1,this.set(t,n,i)}set(t,n,i){if(n===void 0&&i===void 0){let r=t;r&&r.isColor?this.copy(r):typeof r=="number"?this.setHex(r):typeof r=="string"&&this.setStyle(r)}else this.setRGB(t,n,i);return this}setScalar(t){return this.r=t,this.g=t,this.b=t,this}setHex(t,n=Xn){return t=Math.floor(t),this.r=(t>>16&255)/255,this.g=(t>>8&255)/255,this.b=(t&255)/255,ee.colorSpaceToWorking(this,n),this}setRGB(t,n,i,r=ee.workingColorSpace){return this.r=t,this.g=n,this.b=i,ee.colorSpaceToWorking(this,r),this}setHSL(t,n,i,r=ee.workingColorSpace){if(t=Mm(t,1),n=ne(n,0,1),i=ne(i,0,1),n===0)this.r=this.g=this.b=i;else{let s=i<=.5?i*(1+n):i+n-i*n,o=2*i-s;this.r=Cp(o,s,t+1/3),this.g=Cp(o,s,t),this.b=Cp(o,s,t-1/3)}return ee.colorSpaceToWorking(this,r),this}setStyle(t,n=Xn){function i(s){s!==void 0&&parseFloat(s)<1&&Ft("Color: Alpha component of "+t+" will be ignored.")}let r;if(r=/^(\w+)\(([^\)]*)\)/.exec(t)){let s,o=r[1],a=r[2];switch(o){case"rgb":case"rgba":if(s=/^\s*(\d+)\s*,\s*(\d+)\s*,\s*(\d+)\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return i(s[4]),this.setRGB(Math.min(255,parseInt(s[1],10))/255,Math.min(255,parseInt(s[2],10))/255,Math.min(255,parseInt(s[3],10))/255,n);if(s=/^\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return i(s[4]),this.setRGB(Math.min(100,parseFloat(s[1]))/100,Math.min(100,parseFloat(s[2]))/100,Math.min(100,parseFloat(s[3]))/100,n);break;case"hsl":case"hsla":if(s=/^\s*([+-]?(?:\d+(?:\.\d+)?|\.\d+))\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(a))return i(s[4]),this.setHSL(parseFloat(s[1])/360,parseFloat(s[2])/100,parseFloat(s[3])/100,n);break;default:Ft("Color: Unknown color model "+t)}}else if(r=/^\#([A-Fa-f\d]+)$/.exec(t)){let s=r[1],o=s.length;if(o===3)return this.setRGB(parseInt(s.charAt(0),16)/15,parseInt(s.charAt(1),16)/15,parseInt(s.charAt(2),16)/15,n);if(o===6)return this.setHex(parseInt(s,16),n);Ft("Color: Invalid hex color "+t)}else if(t&&t.length>0)return this.setColorName(t,n);return this}setColorName(t,n=Xn){let i=cb[t.toLowerCase()];return i!==void 0?this.setHex(i,n):Ft("Color: Unknown color "+t),this}clone(){return new this.constructor(this.r,this.g,this.b)}copy(t){return this.r=t.r,this.g=t.g,this.b=t.b,this}copySRGBToLinear(t){return this.r=Er(t.r),this.g=Er(t.g),this.b=Er(t.b),this}copyLinearToSRGB(t){return this.r=Xo(t.r),this.g=Xo(t.g),this.b=Xo(t.b),this}convertSRGBToLinear(){return this.copySRGBToLinear(this),this}convertLinearToSRGB(){return this.copyLinearToSRGB(this),this}getHex(t=Xn){return ee.workingToColorSpace(pn.copy(this),t),Math.round(ne(pn.r*255,0,255))*65536+Math.round(ne(pn.g*255,0,255))*256+Math.round(ne(pn.b*255,0,255))}getHexString(t=Xn){return("000000"+this.getHex(t).toString(16)).slice(-6)}getHSL(t,n=ee.workingColorSpace){ee.workingToColorSpace(pn.copy(this),n);let i=pn.r,r=pn.g,s=pn.b,o=Math.max(i,r,s),a=Math.min(i,r,s),c,l,u=(a+o)/2;if(a===o)c=0,l=0;else{let h=o-a;switch(l=u<=.5?h/(o+a):h/(2-o-a),o){case i:c=(r-s)/h+(r<s?6:0);break;case r:c=(s-i)/h+2;break;case s:c=(i-r)/h+4;break}c/=6}return t.h=c,t.s=l,t.l=u,t}getRGB(t,n=ee.workingColorSpace){return ee.workingToColorSpace(pn.copy(this),n),t.r=pn.r,t.g=pn.g,t.b=pn.b,t}getStyle(t=Xn){ee.workingToColorSpace(pn.copy(this),t);let n=pn.r,i=pn.g,r=pn.b;return t!==Xn?`color(${t} ${n.toFixed(3)} ${i.toFixed(3)} ${r.toFixed(3)})`:`rgb(${Math.round(n*255)},${Math.round(i*255)},${Math.round(r*255)})`}offsetHSL(t,n,i){return this.getHSL(os),this.setHSL(os.h+t,os.s+n,os.l+i)}add(t){return this.r+=t.r,this.g+=t.g,this.b+=t.b,this}addColors(t,n){return this.r=t.r+n.r,this.g=t.g+n.g,this.b=t.b+n.b,this}addScalar(t){return this.r+=t,this.g+=t,this.b+=t,this}sub(t){return this.r=Math.max(0,this.r-t.r),this.g=Math.max(0,this.g-t.g),this.b=Math.max(0,this.b-t.b),this}multiply(t){return this.r*=t.r,this.g*=t.g,this.b*=t.b,this}multiplyScalar(t){return this.r*=t,this.g*=t,this.b*=t,this}lerp(t,n){return this.r+=(t.r-this.r)*n,this.g+=(t.g-this.g)*n,this.b+=(t.b-this.b)*n,this}lerpColors(t,n,i){return this.r=t.r+(n.r-t.r)*i,this.g=t.g+(n.g-t.g)*i,this.b=t.b+(n.b-t.b)*i,this}lerpHSL(t,n){this.getHSL(os),t.getHSL(du);let i=xc(os.h,du.h,n),r=xc(os.s,du.s,n),s=xc(os.l,du.l,n);return this.setHSL(i,r,s),this}setFromVector3(t){return this.r=t.x,this.g=t.y,this.b=t.z,this}applyMatrix3(t){let n=this.r,i=this.g,r=this.b,s=t.elements;return this.r=s[0]*n+s[3]*i+s[6]*r,this.g=s[1]*n+s[4]*i+s[7]*r,this.b=s[2]*n+s[5]*i+s[8]*r,this}equals(t){return t.r===this.r&&t.g===this.g&&t.b===this.b}fromArray(t,n=0){return this.r=t[n],this.g=t[n+1],this.b=t[n+2],this}toArray(t=[],n=0){return t[n]=this.r,t[n+1]=this.g,t[n+2]=this.b,t}fromBufferAttribute(t,n){return this.r=t.getX(n),this.g=t.getY(n),this.b=t.getZ(n),this}toJSON(){return this.getHex()}*[Symbol.iterator](){yield this.r,yield this.g,yield this.b}},pn=new Zt;Zt.NAMES=cb;var Tc=class extends wn{constructor(){super(),this.isScene=!0,this.type="Scene",this.background=null,this.environment=null,this.fog=null,this.backgroundBlurriness=0,this.backgroundIntensity=1,this.backgroundRotation=new Rr,this.environmentIntensity=1,this.environmentRotation=new Rr,this.overrideMaterial=null,typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}copy(t,n){return super.copy(t,n),this.background=t.background!==null?t.background.clone():null,this.environment=t.environment!==null?t.environment.clone():null,this.fog=t.fog!==null?t.fog.clone():null,this.backgroundBlurriness=t.backgroundBlurriness,this.backgroundIntensity=t.backgroundIntensity,this.backgroundRotation.copy(t.backgroundRotation),this.environmentIntensity=t.environmentIntensity,this.environmentRotation.copy(t.environmentRotation),this.overrideMaterial=t.overrideMaterial!==null?t.overrideMaterial.clone():null,this.matrixAutoUpdate=t.matrixAutoUpdate,this}toJSON(t){let n=super.toJSON(t);return this.fog!==null&&(n.object.fog=this.fog.toJSON()),n.object.backgroundBlurriness=this.backgroundBlurriness,n.object.backgroundIntensity=this.backgroundIntensity,n.object.backgroundRotation=this.backgroundRotation.toArray(),n.object.environmentIntensity=this.environmentIntensity,n.object.environmentRotation=this.environmentRotation.toArray(),n}},Ti=new W,Mr=new W,Rp=new W,Sr=new W,Oo=new W,Bo=new W,fv=new W,Ip=new W,Pp=new W,Lp=new W,Np=new Te,Dp=new Te,Fp=new Te,us=class e{constructor(t=new W,n=new W,i=new W){this.a=t,this.b=n,this.c=i}static getNormal(t,n,i,r){r.subVectors(i,n),Ti.subVectors(t,n),r.cross(Ti);let s=r.lengthSq();return s>0?r.multiplyScalar(1/Math.sqrt(s)):r.set(0,0,0)}static getBarycoord(t,n,i,r,s){Ti.subVectors(r,n),Mr.subVectors(i,n),Rp.subVectors(t,n);let o=Ti.dot(Ti),a=Ti.dot(Mr),c=Ti.dot(Rp),l=Mr.dot(Mr),u=Mr.dot(Rp),h=o*l-a*a;if(h===0)return s.set(0,0,0),null;let f=1/h,d=(l*c-a*u)*f,p=(o*u-a*c)*f;return s.set(1-d-p,p,d)}static containsPoint(t,n,i,r){return this.getBarycoord(t,n,i,r,Sr)===null?!1:Sr.x>=0&&Sr.y>=0&&Sr.x+Sr.y<=1}static getInterpolation(t,n,i,r,s,o,a,c){return this.getBarycoord(t,n,i,r,Sr)===null?(c.x=0,c.y=0,"z"in c&&(c.z=0),"w"in c&&(c.w=0),null):(c.setScalar(0),c.addScaledVector(s,Sr.x),c.addScaledVector(o,Sr.y),c.addScaledVector(a,Sr.z),c)}static getInterpolatedAttribute(t,n,i,r,s,o){return Np.setScalar(0),Dp.setScalar(0),Fp.setScalar(0),Np.fromBufferAttribute(t,n),Dp.fromBufferAttribute(t,i),Fp.fromBufferAttribute(t,r),o.setScalar(0),o.addScaledVector(Np,s.x),o.addScaledVector(Dp,s.y),o.addScaledVector(Fp,s.z),o}static isFrontFacing(t,n,i,r){return Ti.subVectors(i,n),Mr.subVectors(t,n),Ti.cross(Mr).dot(r)<0}set(t,n,i){return this.a.copy(t),this.b.copy(n),this.c.copy(i),this}setFromPointsAndIndices(t,n,i,r){return this.a.copy(t[n]),this.b.copy(t[i]),this.c.copy(t[r]),this}setFromAttributeAndIndices(t,n,i,r){return this.a.fromBufferAttribute(t,n),this.b.fromBufferAttribute(t,i),this.c.fromBufferAttribute(t,r),this}clone(){return new this.constructor().copy(this)}copy(t){return this.a.copy(t.a),this.b.copy(t.b),this.c.copy(t.c),this}getArea(){return Ti.subVectors(this.c,this.b),Mr.subVectors(this.a,this.b),Ti.cross(Mr).length()*.5}getMidpoint(t){return t.addVectors(this.a,this.b).add(this.c).multiplyScalar(1/3)}getNormal(t){return e.getNormal(this.a,this.b,this.c,t)}getPlane(t){return t.setFromCoplanarPoints(this.a,this.b,this.c)}getBarycoord(t,n){return e.getBarycoord(t,this.a,this.b,this.c,n)}getInterpolation(t,n,i,r,s){return e.getInterpolation(t,this.a,this.b,this.c,n,i,r,s)}containsPoint(t){return e.containsPoint(t,this.a,this.b,this.c)}isFrontFacing(t){return e.isFrontFacing(this.a,this.b,this.c,t)}intersectsBox(t){return t.intersectsTriangle(this)}closestPointToPoint(t,n){let i=this.a,r=this.b,s=this.c,o,a;Oo.subVectors(r,i),Bo.subVectors(s,i),Ip.subVectors(t,i);let c=Oo.dot(Ip),l=Bo.dot(Ip);if(c<=0&&l<=0)return n.copy(i);Pp.subVectors(t,r);let u=Oo.dot(Pp),h=Bo.dot(Pp);if(u>=0&&h<=u)return n.copy(r);let f=c*h-u*l;if(f<=0&&c>=0&&u<=0&&c-u>0)return o=c/(c-u),n.copy(i).addScaledVector(Oo,o);Lp.subVectors(t,s);let d=Oo.dot(Lp),p=Bo.dot(Lp);if(p>=0&&d<=p)return n.copy(s);let y=d*l-c*p;if(y<=0&&l>=0&&p<=0)return a=l/(l-p),n.copy(i).addScaledVector(Bo,a);let m=u*p-d*h;if(m<=0&&h-u>=0&&d-p>=0)return fv.subVectors(s,r),a=(h-u)/(h-u+(d-p)),n.copy(r).addScaledVector(fv,a);let g=1/(m+y+f);return o=y*g,a=f*g,n.copy(i).addScaledVector(Oo,o).addScaledVector(Bo,a)}equals(t){return t.a.equals(this.a)&&t.b.equals(this.b)&&t.c.equals(this.c)}},Un=class{constructor(t=new W(1/0,1/0,1/0),n=new W(-1/0,-1/0,-1/0)){this.isBox3=!0,this.min=t,this.max=n}set(t,n){return this.min.copy(t),this.max.copy(n),this}setFromArray(t){this.makeEmpty();for(let n=0,i=t.length;n<i;n+=3)this.expandByPoint(Ai.fromArray(t,n));return this}setFromBufferAttribute(t){this.makeEmpty();for(let n=0,i=t.count;n<i;n++)this.expandByPoint(Ai.fromBufferAttribute(t,n));return this}setFromPoints(t){this.makeEmpty();for(let n=0,i=t.length;n<i;n++)this.expandByPoint(t[n]);return this}setFromCenterAndSize(t,n){let i=Ai.copy(n).multiplyScalar(.5);return this.min.copy(t).sub(i),this.max.copy(t).add(i),this}setFromObject(t,n=!1){return this.makeEmpty(),this.expandByObject(t,n)}clone(){return new this.constructor().copy(this)}copy(t){return this.min.copy(t.min),this.max.copy(t.max),this}makeEmpty(){return this.min.x=this.min.y=this.min.z=1/0,this.max.x=this.max.y=this.max.z=-1/0,this}isEmpty(){return this.max.x<this.min.x||this.max.y<this.min.y||this.max.z<this.min.z}getCenter(t){return this.isEmpty()?t.set(0,0,0):t.addVectors(this.min,this.max).multiplyScalar(.5)}getSize(t){return this.isEmpty()?t.set(0,0,0):t.subVectors(this.max,this.min)}expandByPoint(t){return this.min.min(t),this.max.max(t),this}expandByVector(t){return this.min.sub(t),this.max.add(t),this}expandByScalar(t){return this.min.addScalar(-t),this.max.addScalar(t),this}expandByObject(t,n=!1){t.updateWorldMatrix(!1,!1);let i=t.geometry;if(i!==void 0){let s=i.getAttribute("position");if(n===!0&&s!==void 0&&t.isInstancedMesh!==!0&&t.isBatchedMesh!==!0)for(let o=0,a=s.count;o<a;o++)t.isMesh===!0?t.getVertexPosition(o,Ai):Ai.fromBufferAttribute(s,o),Ai.applyMatrix4(t.matrixWorld),this.expandByPoint(Ai);else t.boundingBox!==void 0?(t.boundingBox===null&&t.computeBoundingBox(),pu.copy(t.boundingBox)):(i.boundingBox===null&&i.computeBoundingBox(),pu.copy(i.boundingBox)),pu.applyMatrix4(t.matrixWorld),this.union(pu)}let r=t.children;for(let s=0,o=r.length;s<o;s++)this.expandByObject(r[s],n);return this}containsPoint(t){return t.x>=this.min.x&&t.x<=this.max.x&&t.y>=this.min.y&&t.y<=this.max.y&&t.z>=this.min.z&&t.z<=this.max.z}containsBox(t){return this.min.x<=t.min.x&&t.max.x<=this.max.x&&this.min.y<=t.min.y&&t.max.y<=this.max.y&&this.min.z<=t.min.z&&t.max.z<=this.max.z}getParameter(t,n){return n.set((t.x-this.min.x)/(this.max.x-this.min.x),(t.y-this.min.y)/(this.max.y-this.min.y),(t.z-this.min.z)/(this.max.z-this.min.z))}intersectsBox(t){return t.max.x>=this.min.x&&t.min.x<=this.max.x&&t.max.y>=this.min.y&&t.min.y<=this.max.y&&t.max.z>=this.min.z&&t.min.z<=this.max.z}intersectsSphere(t){return this.clampPoint(t.center,Ai),Ai.distanceToSquared(t.center)<=t.radius*t.radius}intersectsPlane(t){let n,i;return t.normal.x>0?(n=t.normal.x*this.min.x,i=t.normal.x*this.max.x):(n=t.normal.x*this.max.x,i=t.normal.x*this.min.x),t.normal.y>0?(n+=t.normal.y*this.min.y,i+=t.normal.y*this.max.y):(n+=t.normal.y*this.max.y,i+=t.normal.y*this.min.y),t.normal.z>0?(n+=t.normal.z*this.min.z,i+=t.normal.z*this.max.z):(n+=t.normal.z*this.max.z,i+=t.normal.z*this.min.z),n<=-t.constant&&i>=-t.constant}intersectsTriangle(t){if(this.isEmpty())return!1;this.getCenter(dc),mu.subVectors(this.max,dc),ko.subVectors(t.a,dc),zo.subVectors(t.b,dc),Go.subVectors(t.c,dc),as.subVectors(zo,ko),cs.subVectors(Go,zo),Ws.subVectors(ko,Go);let n=[0,-as.z,as.y,0,-cs.z,cs.y,0,-Ws.z,Ws.y,as.z,0,-as.x,cs.z,0,-cs.x,Ws.z,0,-Ws.x,-as.y,as.x,0,-cs.y,cs.x,0,-Ws.y,Ws.x,0];return!Up(n,ko,zo,Go,mu)||(n=[1,0,0,0,1,0,0,0,1],!Up(n,ko,zo,Go,mu))?!1:(gu.crossVectors(as,cs),n=[gu.x,gu.y,gu.z],Up(n,ko,zo,Go,mu))}clampPoint(t,n){return n.copy(t).clamp(this.min,this.max)}distanceToPoint(t){return this.clampPoint(t,Ai).distanceTo(t)}getBoundingSphere(t){return this.isEmpty()?t.makeEmpty():(this.getCenter(t.center),t.radius=this.getSize(Ai).length()*.5),t}intersect(t){return this.min.max(t.min),this.max.min(t.max),this.isEmpty()&&this.makeEmpty(),this}union(t){return this.min.min(t.min),this.max.max(t.max),this}applyMatrix4(t){return this.isEmpty()?this:(wr[0].set(this.min.x,this.min.y,this.min.z).applyMatrix4(t),wr[1].set(this.min.x,this.min.y,this.max.z).applyMatrix4(t),wr[2].set(this.min.x,this.max.y,this.min.z).applyMatrix4(t),wr[3].set(this.min.x,this.max.y,this.max.z).applyMatrix4(t),wr[4].set(this.max.x,this.min.y,this.min.z).applyMatrix4(t),wr[5].set(this.max.x,this.min.y,this.max.z).applyMatrix4(t),wr[6].set(this.max.x,this.max.y,this.min.z).applyMatrix4(t),wr[7].set(this.max.x,this.max.y,this.max.z).applyMatrix4(t),this.setFromPoints(wr),this)}translate(t){return this.min.add(t),this.max.add(t),this}equals(t){return t.min.equals(this.min)&&t.max.equals(this.max)}toJSON(){return{min:this.min.toArray(),max:this.max.toArray()}}fromJSON(t){return this.min.fromArray(t.min),this.max.fromArray(t.max),this}},wr=[new W,new W,new W,new W,new W,new W,new W,new W],Ai=new W,pu=new Un,ko=new W,zo=new W,Go=new W,as=new W,cs=new W,Ws=new W,dc=new W,mu=new W,gu=new W,$s=new W;function Up(e,t,n,i,r){for(let s=0,o=e.length-3;s<=o;s+=3){$s.fromArray(e,s);let a=r.x*Math.abs($s.x)+r.y*Math.abs($s.y)+r.z*Math.abs($s.z),c=t.dot($s),l=n.dot($s),u=i.dot($s);if(Math.max(-Math.max(c,l,u),Math.min(c,l,u))>a)return!1}return!0}var ze=new W,yu=new ie,oC=0,bn=class extends Xi{constructor(t,n,i=!1){if(super(),Array.isArray(t))throw new TypeError("THREE.BufferAttribute: array should be a Typed Array.");this.isBufferAttribute=!0,Object.defineProperty(this,"id",{value:oC++}),this.name="",this.array=t,this.itemSize=n,this.count=t!==void 0?t.length/n:0,this.normalized=i,this.usage=eb,this.updateRanges=[],this.gpuType=Ri,this.version=0,this._normalizationScale=t!==void 0?wm(t):void 0}onUploadCallback(){}set needsUpdate(t){t===!0&&this.version++}setUsage(t){return this.usage=t,this}addUpdateRange(t,n){this.updateRanges.push({start:t,count:n})}clearUpdateRanges(){this.updateRanges.length=0}copy(t){return this.name=t.name,this.array=new t.array.constructor(t.array),this.itemSize=t.itemSize,this.count=t.count,this.normalized=t.normalized,this.usage=t.usage,this.gpuType=t.gpuType,this._normalizationScale=t._normalizationScale,this}copyAt(t,n,i){t*=this.itemSize,i*=n.itemSize;for(let r=0,s=this.itemSize;r<s;r++)this.array[t+r]=n.array[i+r];return this}copyArray(t){return this.array.set(t),this}applyMatrix3(t){if(this.itemSize===2)for(let n=0,i=this.count;n<i;n++)yu.fromBufferAttribute(this,n),yu.applyMatrix3(t),this.setXY(n,yu.x,yu.y);else if(this.itemSize===3)for(let n=0,i=this.count;n<i;n++)ze.fromBufferAttribute(this,n),ze.applyMatrix3(t),this.setXYZ(n,ze.x,ze.y,ze.z);return this}applyMatrix4(t){for(let n=0,i=this.count;n<i;n++)ze.fromBufferAttribute(this,n),ze.applyMatrix4(t),this.setXYZ(n,ze.x,ze.y,ze.z);return this}applyNormalMatrix(t){for(let n=0,i=this.count;n<i;n++)ze.fromBufferAttribute(this,n),ze.applyNormalMatrix(t),this.setXYZ(n,ze.x,ze.y,ze.z);return this}transformDirection(t){for(let n=0,i=this.count;n<i;n++)ze.fromBufferAttribute(this,n),ze.transformDirection(t),this.setXYZ(n,ze.x,ze.y,ze.z);return this}set(t,n=0){return this.array.set(t,n),this}getComponent(t,n){let i=this.array[t*this.itemSize+n];return this.normalized&&(i=this._denormalize(i)),i}setComponent(t,n,i){return this.normalized&&(i=this._normalize(i)),this.array[t*this.itemSize+n]=i,this}getX(t){let n=this.array[t*this.itemSize];return this.normalized&&(n=this._denormalize(n)),n}setX(t,n){return this.normalized&&(n=this._normalize(n)),this.array[t*this.itemSize]=n,this}getY(t){let n=this.array[t*this.itemSize+1];return this.normalized&&(n=this._denormalize(n)),n}setY(t,n){return this.normalized&&(n=this._normalize(n)),this.array[t*this.itemSize+1]=n,this}getZ(t){let n=this.array[t*this.itemSize+2];return this.normalized&&(n=this._denormalize(n)),n}setZ(t,n){return this.normalized&&(n=this._normalize(n)),this.array[t*this.itemSize+2]=n,this}getW(t){let n=this.array[t*this.itemSize+3];return this.normalized&&(n=this._denormalize(n)),n}setW(t,n){return this.normalized&&(n=this._normalize(n)),this.array[t*this.itemSize+3]=n,this}setXY(t,n,i){return t*=this.itemSize,this.normalized&&(n=this._normalize(n),i=this._normalize(i)),this.array[t+0]=n,this.array[t+1]=i,this}setXYZ(t,n,i,r){return t*=this.itemSize,this.normalized&&(n=this._normalize(n),i=this._normalize(i),r=this._normalize(r)),this.array[t+0]=n,this.array[t+1]=i,this.array[t+2]=r,this}setXYZW(t,n,i,r,s){return t*=this.itemSize,this.normalized&&(n=this._normalize(n),i=this._normalize(i),r=this._normalize(r),s=this._normalize(s)),this.array[t+0]=n,this.array[t+1]=i,this.array[t+2]=r,this.array[t+3]=s,this}onUpload(t){return this.onUploadCallback=t,this}clone(){return new this.constructor(this.array,this.itemSize).copy(this)}toJSON(){let t={itemSize:this.itemSize,type:this.array.constructor.name,array:Array.from(this.array),normalized:this.normalized};return t.name=this.name,t.usage=this.usage,t.gpuType=this.gpuType,t}dispose(){this.dispatchEvent({type:"dispose"})}_denormalize(t){let n=this._normalizationScale;return n!==void 0?Math.max(t/n,-1):ob(t,this.array)}_normalize(t){let n=this._normalizationScale;return n!==void 0?Math.round(t*n):ab(t,this.array)}};var Ac=class extends bn{constructor(t,n,i){super(new Uint16Array(t),n,i)}};var Ec=class extends bn{constructor(t,n,i){super(new Uint32Array(t),n,i)}};var Ke=class extends bn{constructor(t,n,i){super(new Float32Array(t),n,i)}},aC=new Un,pc=new W,Op=new W,Qo=class{constructor(t=new W,n=-1){this.isSphere=!0,this.center=t,this.radius=n}set(t,n){return this.center.copy(t),this.radius=n,this}setFromPoints(t,n){let i=this.center;n!==void 0?i.copy(n):aC.setFromPoints(t).getCenter(i);let r=0;for(let s=0,o=t.length;s<o;s++)r=Math.max(r,i.distanceToSquared(t[s]));return this.radius=Math.sqrt(r),this}copy(t){return this.center.copy(t.center),this.radius=t.radius,this}isEmpty(){return this.radius<0}makeEmpty(){return this.center.set(0,0,0),this.radius=-1,this}containsPoint(t){return t.distanceToSquared(this.center)<=this.radius*this.radius}distanceToPoint(t){return t.distanceTo(this.center)-this.radius}intersectsSphere(t){let n=this.radius+t.radius;return t.center.distanceToSquared(this.center)<=n*n}intersectsBox(t){return t.intersectsSphere(this)}intersectsPlane(t){return Math.abs(t.distanceToPoint(this.center))<=this.radius}clampPoint(t,n){let i=this.center.distanceToSquared(t);return n.copy(t),i>this.radius*this.radius&&(n.sub(this.center).normalize(),n.multiplyScalar(this.radius).add(this.center)),n}getBoundingBox(t){return this.isEmpty()?(t.makeEmpty(),t):(t.set(this.center,this.center),t.expandByScalar(this.radius),t)}applyMatrix4(t){return this.center.applyMatrix4(t),this.radius=this.radius*t.getMaxScaleOnAxis(),this}translate(t){return this.center.add(t),this}expandByPoint(t){if(this.isEmpty())return this.center.copy(t),this.radius=0,this;pc.subVectors(t,this.center);let n=pc.lengthSq();if(n>this.radius*this.radius){let i=Math.sqrt(n),r=(i-this.radius)*.5;this.center.addScaledVector(pc,r/i),this.radius+=r}return this}union(t){return t.isEmpty()?this:this.isEmpty()?(this.copy(t),this):(this.center.equals(t.center)===!0?this.radius=Math.max(this.radius,t.radius):(Op.subVectors(t.center,this.center).setLength(t.radius),this.expandByPoint(pc.copy(t.center).add(Op)),this.expandByPoint(pc.copy(t.center).sub(Op))),this)}equals(t){return t.center.equals(this.center)&&t.radius===this.radius}clone(){return new this.constructor().copy(this)}toJSON(){return{radius:this.radius,center:this.center.toArray()}}fromJSON(t){return this.radius=t.radius,this.center.fromArray(t.center),this}},cC=0,ni=new we,Bp=new wn,Vo=new W,$n=new Un,mc=new Un,Je=new W,ri=class e extends Xi{constructor(){super(),this.isBufferGeometry=!0,Object.defineProperty(this,"id",{value:cC++}),this.uuid=oa(),this.name="",this.type="BufferGeometry",this.index=null,this.indirect=null,this.indirectOffset=0,this.attributes={},this.morphAttributes={},this.morphTargetsRelative=!1,this.groups=[],this.boundingBox=null,this.boundingSphere=null,this.drawRange={start:0,count:1/0},this.userData={},this._transformed=!1}getIndex(){return this.index}setIndex(t){return Array.isArray(t)?this.index=new(N3(t)?Ec:Ac)(t,1):this.index=t,this}setIndirect(t,n=0){return this.indirect=t,this.indirectOffset=n,this}getIndirect(){return this.indirect}getAttribute(t){return this.attributes[t]}setAttribute(t,n){return this.attributes[t]=n,this}deleteAttribute(t){return delete this.attributes[t],this}hasAttribute(t){return this.attributes[t]!==void 0}addGroup(t,n,i=0){this.groups.push({start:t,count:n,materialIndex:i})}clearGroups(){this.groups=[]}setDrawRange(t,n){this.drawRange.start=t,this.drawRange.count=n}applyMatrix4(t){let n=this.attributes.position;n!==void 0&&(n.applyMatrix4(t),n.needsUpdate=!0);let i=this.attributes.normal;if(i!==void 0){let s=new zt().getNormalMatrix(t);i.applyNormalMatrix(s),i.needsUpdate=!0}let r=this.attributes.tangent;return r!==void 0&&(r.transformDirection(t),r.needsUpdate=!0),this.boundingBox!==null&&this.computeBoundingBox(),this.boundingSphere!==null&&this.computeBoundingSphere(),this._transformed=!0,this}applyQuaternion(t){return ni.makeRotationFromQuaternion(t),this.applyMatrix4(ni),this}rotateX(t){return ni.makeRotationX(t),this.applyMatrix4(ni),this}rotateY(t){return ni.makeRotationY(t),this.applyMatrix4(ni),this}rotateZ(t){return ni.makeRotationZ(t),this.applyMatrix4(ni),this}translate(t,n,i){return ni.makeTranslation(t,n,i),this.applyMatrix4(ni),this}scale(t,n,i){return ni.makeScale(t,n,i),this.applyMatrix4(ni),this}lookAt(t){return Bp.lookAt(t),Bp.updateMatrix(),this.applyMatrix4(Bp.matrix),this}center(){return this.computeBoundingBox(),this.boundingBox.getCenter(Vo).negate(),this.translate(Vo.x,Vo.y,Vo.z),this}setFromPoints(t){let n=this.getAttribute("position");if(n===void 0){let i=[];for(let r=0,s=t.length;r<s;r++){let o=t[r];i.push(o.x,o.y,o.z||0)}this.setAttribute("position",new Ke(i,3))}else{let i=Math.min(t.length,n.count);for(let r=0;r<i;r++){let s=t[r];n.setXYZ(r,s.x,s.y,s.z||0)}t.length>n.count&&Ft("BufferGeometry: Buffer size too small for points data. Use .dispose() and create a new geometry."),n.needsUpdate=!0}return this}computeBoundingBox(){this.boundingBox===null&&(this.boundingBox=new Un);let t=this.attributes.position,n=this.morphAttributes.position;if(t&&t.isGLBufferAttribute){kt("BufferGeometry.computeBoundingBox(): GLBufferAttribute requires a manual bounding box.",this),this.boundingBox.set(new W(-1/0,-1/0,-1/0),new W(1/0,1/0,1/0));return}if(t!==void 0){if(this.boundingBox.setFromBufferAttribute(t),n)for(let i=0,r=n.length;i<r;i++){let s=n[i];$n.setFromBufferAttribute(s),this.morphTargetsRelative?(Je.addVectors(this.boundingBox.min,$n.min),this.boundingBox.expandByPoint(Je),Je.addVectors(this.boundingBox.max,$n.max),this.boundingBox.expandByPoint(Je)):(this.boundingBox.expandByPoint($n.min),this.boundingBox.expandByPoint($n.max))}}else this.boundingBox.makeEmpty();(isNaN(this.boundingBox.min.x)||isNaN(this.boundingBox.min.y)||isNaN(this.boundingBox.min.z))&&kt('BufferGeometry.computeBoundingBox(): Computed min/max have NaN values. The "position" attribute is likely to have NaN values.',this)}computeBoundingSphere(){this.boundingSphere===null&&(this.boundingSphere=new Qo);let t=this.attributes.position,n=this.morphAttributes.position;if(t&&t.isGLBufferAttribute){kt("BufferGeometry.computeBoundingSphere(): GLBufferAttribute requires a manual bounding sphere.",this),this.boundingSphere.set(new W,1/0);return}if(t){let i=this.boundingSphere.center;if($n.setFromBufferAttribute(t),n)for(let s=0,o=n.length;s<o;s++){let a=n[s];mc.setFromBufferAttribute(a),this.morphTargetsRelative?(Je.addVectors($n.min,mc.min),$n.expandByPoint(Je),Je.addVectors($n.max,mc.max),$n.expandByPoint(Je)):($n.expandByPoint(mc.min),$n.expandByPoint(mc.max))}$n.getCenter(i);let r=0;for(let s=0,o=t.count;s<o;s++)Je.fromBufferAttribute(t,s),r=Math.max(r,i.distanceToSquared(Je));if(n)for(let s=0,o=n.length;s<o;s++){let a=n[s],c=this.morphTargetsRelative;for(let l=0,u=a.count;l<u;l++)Je.fromBufferAttribute(a,l),c&&(Vo.fromBufferAttribute(t,l),Je.add(Vo)),r=Math.max(r,i.distanceToSquared(Je))}this.boundingSphere.radius=Math.sqrt(r),isNaN(this.boundingSphere.radius)&&kt('BufferGeometry.computeBoundingSphere(): Computed radius is NaN. The "position" attribute is likely to have NaN values.',this)}}computeTangents(){let t=this.index,n=this.attributes;if(t===null||n.position===void 0||n.normal===void 0||n.uv===void 0){kt("BufferGeometry: .computeTangents() failed. Missing required attributes (index, position, normal or uv)");return}let i=n.position,r=n.normal,s=n.uv,o=this.getAttribute("tangent");(o===void 0||o.count!==i.count)&&(o=new bn(new Float32Array(4*i.count),4),this.setAttribute("tangent",o));let a=[],c=[],l=new Uint8Array(i.count);for(let R=0;R<i.count;R++)a[R]=new W,c[R]=new W;let u=new W,h=new W,f=new W,d=new ie,p=new ie,y=new ie,m=new W,g=new W;function v(R,E,C){l[R]=l[E]=l[C]=1,u.fromBufferAttribute(i,R),h.fromBufferAttribute(i,E),f.fromBufferAttribute(i,C),d.fromBufferAttribute(s,R),p.fromBufferAttribute(s,E),y.fromBufferAttribute(s,C),h.sub(u),f.sub(u),p.sub(d),y.sub(d);let N=1/(p.x*y.y-y.x*p.y);isFinite(N)&&(m.copy(h).multiplyScalar(y.y).addScaledVector(f,-p.y).multiplyScalar(N),g.copy(f).multiplyScalar(p.x).addScaledVector(h,-y.x).multiplyScalar(N),a[R].add(m),a[E].add(m),a[C].add(m),c[R].add(g),c[E].add(g),c[C].add(g))}let S=this.groups;S.length===0&&(S=[{start:0,count:t.count}]);for(let R=0,E=S.length;R<E;++R){let C=S[R],N=C.start,B=C.count;for(let I=N,L=N+B;I<L;I+=3)v(t.getX(I+0),t.getX(I+1),t.getX(I+2))}let _=new W,w=new W,b=new W,x=new W;function M(R){b.fromBufferAttribute(r,R),x.copy(b);let E=a[R];_.copy(E),_.sub(b.multiplyScalar(b.dot(E))).normalize(),w.crossVectors(x,E);let N=w.dot(c[R])<0?-1:1;o.setXYZW(R,_.x,_.y,_.z,N)}for(let R=0,E=i.count;R<E;++R)l[R]&&M(R);this._transformed=!0}computeVertexNormals(){let t=this.index,n=this.getAttribute("position");if(n!==void 0){let i=this.getAttribute("normal");if(i===void 0||i.count!==n.count)i=new bn(new Float32Array(n.count*3),3),this.setAttribute("normal",i);else for(let f=0,d=i.count;f<d;f++)i.setXYZ(f,0,0,0);let r=new W,s=new W,o=new W,a=new W,c=new W,l=new W,u=new W,h=new W;if(t)for(let f=0,d=t.count;f<d;f+=3){let p=t.getX(f+0),y=t.getX(f+1),m=t.getX(f+2);r.fromBufferAttribute(n,p),s.fromBufferAttribute(n,y),o.fromBufferAttribute(n,m),u.subVectors(o,s),h.subVectors(r,s),u.cross(h),a.fromBufferAttribute(i,p),c.fromBufferAttribute(i,y),l.fromBufferAttribute(i,m),a.add(u),c.add(u),l.add(u),i.setXYZ(p,a.x,a.y,a.z),i.setXYZ(y,c.x,c.y,c.z),i.setXYZ(m,l.x,l.y,l.z)}else for(let f=0,d=n.count;f<d;f+=3)r.fromBufferAttribute(n,f+0),s.fromBufferAttribute(n,f+1),o.fromBufferAttribute(n,f+2),u.subVectors(o,s),h.subVectors(r,s),u.cross(h),i.setXYZ(f+0,u.x,u.y,u.z),i.setXYZ(f+1,u.x,u.y,u.z),i.setXYZ(f+2,u.x,u.y,u.z);this.normalizeNormals(),i.needsUpdate=!0}}normalizeNormals(){let t=this.attributes.normal;for(let n=0,i=t.count;n<i;n++)Je.fromBufferAttribute(t,n),Je.normalize(),t.setXYZ(n,Je.x,Je.y,Je.z)}toNonIndexed(){function t(a,c){let l=a.array,u=a.itemSize,h=a.normalized,f=new l.constructor(c.length*u),d=0,p=0;for(let y=0,m=c.length;y<m;y++){a.isInterleavedBufferAttribute?d=c[y]*a.data.stride+a.offset:d=c[y]*u;for(let g=0;g<u;g++)f[p++]=l[d++]}return new bn(f,u,h)}if(this.index===null)return Ft("BufferGeometry.toNonIndexed(): BufferGeometry is already non-indexed."),this;let n=new e,i=this.index.array,r=this.attributes;for(let a in r){let c=r[a],l=t(c,i);n.setAttribute(a,l)}let s=this.morphAttributes;for(let a in s){let c=[],l=s[a];for(let u=0,h=l.length;u<h;u++){let f=l[u],d=t(f,i);c.push(d)}n.morphAttributes[a]=c}n.morphTargetsRelative=this.morphTargetsRelative;let o=this.groups;for(let a=0,c=o.length;a<c;a++){let l=o[a];n.addGroup(l.start,l.count,l.materialIndex)}return n}toJSON(){let t={metadata:{version:4.7,type:"BufferGeometry",generator:"BufferGeometry.toJSON"}};if(t.uuid=this.uuid,t.type=this.parameters!==void 0&&this._transformed===!0?"BufferGeometry":this.type,t.name=this.name,Object.keys(this.userData).length>0&&(t.userData=this.userData),this.parameters!==void 0&&this._transformed!==!0){let c=this.parameters;for(let l in c)c[l]!==void 0&&(t[l]=c[l]);return t}t.data={attributes:{}};let n=this.index;n!==null&&(t.data.index={type:n.array.constructor.name,array:Array.prototype.slice.call(n.array)});let i=this.attributes;for(let c in i){let l=i[c];t.data.attributes[c]=l.toJSON(t.data)}let r={},s=!1;for(let c in this.morphAttributes){let l=this.morphAttributes[c],u=[];for(let h=0,f=l.length;h<f;h++){let d=l[h];u.push(d.toJSON(t.data))}u.length>0&&(r[c]=u,s=!0)}s&&(t.data.morphAttributes=r,t.data.morphTargetsRelative=this.morphTargetsRelative);let o=this.groups;o.length>0&&(t.data.groups=JSON.parse(JSON.stringify(o)));let a=this.boundingSphere;return a!==null&&(t.data.boundingSphere=a.toJSON()),t}clone(){return new this.constructor().copy(this)}copy(t){this.index=null,this.attributes={},this.morphAttributes={},this.groups=[],this.boundingBox=null,this.boundingSphere=null;let n={};this.name=t.name;let i=t.index;i!==null&&this.setIndex(i.clone());let r=t.attributes;for(let l in r){let u=r[l];this.setAttribute(l,u.clone(n))}let s=t.morphAttributes;for(let l in s){let u=[],h=s[l];for(let f=0,d=h.length;f<d;f++)u.push(h[f].clone(n));this.morphAttributes[l]=u}this.morphTargetsRelative=t.morphTargetsRelative;let o=t.groups;for(let l=0,u=o.length;l<u;l++){let h=o[l];this.addGroup(h.start,h.count,h.materialIndex)}let a=t.boundingBox;a!==null&&(this.boundingBox=a.clone());let c=t.boundingSphere;return c!==null&&(this.boundingSphere=c.clone()),this.drawRange.start=t.drawRange.start,this.drawRange.count=t.drawRange.count,this.userData=t.userData,this._transformed=t._transformed,this}dispose(){this.dispatchEvent({type:"dispose"})}};var kp=new W,lC=new W,uC=new zt,Ei=class{constructor(t=new W(1,0,0),n=0){this.isPlane=!0,this.normal=t,this.constant=n}set(t,n){return this.normal.copy(t),this.constant=n,this}setComponents(t,n,i,r){return this.normal.set(t,n,i),this.constant=r,this}setFromNormalAndCoplanarPoint(t,n){return this.normal.copy(t),this.constant=-n.dot(this.normal),this}setFromCoplanarPoints(t,n,i){let r=kp.subVectors(i,n).cross(lC.subVectors(t,n)).normalize();return this.setFromNormalAndCoplanarPoint(r,t),this}copy(t){return this.normal.copy(t.normal),this.constant=t.constant,this}normalize(){let t=1/this.normal.length();return this.normal.multiplyScalar(t),this.constant*=t,this}negate(){return this.constant*=-1,this.normal.negate(),this}distanceToPoint(t){return this.normal.dot(t)+this.constant}distanceToSphere(t){return this.distanceToPoint(t.center)-t.radius}projectPoint(t,n){return n.copy(t).addScaledVector(this.normal,-this.distanceToPoint(t))}intersectLine(t,n,i=!0){let r=t.delta(kp),s=this.normal.dot(r);if(s===0)return this.distanceToPoint(t.start)===0?n.copy(t.start):null;let o=-(t.start.dot(this.normal)+this.constant)/s;return i===!0&&(o<0||o>1)?null:n.copy(t.start).addScaledVector(r,o)}intersectsLine(t){let n=this.distanceToPoint(t.start),i=this.distanceToPoint(t.end);return n<0&&i>0||i<0&&n>0}intersectsBox(t){return t.intersectsPlane(this)}intersectsSphere(t){return t.intersectsPlane(this)}coplanarPoint(t){return t.copy(this.normal).multiplyScalar(-this.constant)}applyMatrix4(t,n){let i=n||uC.getNormalMatrix(t),r=this.coplanarPoint(kp).applyMatrix4(t),s=this.normal.applyMatrix3(i).normalize();return this.constant=-r.dot(s),this}translate(t){return this.constant-=t.dot(this.normal),this}equals(t){return t.normal.equals(this.normal)&&t.constant===this.constant}clone(){return new this.constructor().copy(this)}toJSON(){return{normal:this.normal.toArray(),constant:this.constant}}fromJSON(t){return this.normal.fromArray(t.normal),this.constant=t.constant,this}},fC=0,fs=class extends Xi{constructor(){super(),this.isMaterial=!0,Object.defineProperty(this,"id",{value:fC++}),this.uuid=oa(),this.name="",this.type="Material",this.blending=ia,this.side=ys,this.vertexColors=!1,this.opacity=1,this.transparent=!1,this.alphaHash=!1,this.blendSrc=tm,this.blendDst=em,this.blendEquation=Js,this.blendSrcAlpha=null,this.blendDstAlpha=null,this.blendEquationAlpha=null,this.blendColor=new Zt(0,0,0),this.blendAlpha=0,this.depthFunc=qo,this.depthTest=!0,this.depthWrite=!0,this.stencilWriteMask=255,this.stencilFunc=Zv,this.stencilRef=0,this.stencilFuncMask=255,this.stencilFail=Lu,this.stencilZFail=Lu,this.stencilZPass=Lu,this.stencilWrite=!1,this.clippingPlanes=null,this.clipIntersection=!1,this.clipShadows=!1,this.shadowSide=null,this.colorWrite=!0,this.precision=null,this.polygonOffset=!1,this.polygonOffsetFactor=0,this.polygonOffsetUnits=0,this.dithering=!1,this.alphaToCoverage=!1,this.premultipliedAlpha=!1,this.forceSinglePass=!1,this.allowOverride=!0,this.visible=!0,this.toneMapped=!0,this.userData={},this.version=0,this._alphaTest=0}get alphaTest(){return this._alphaTest}set alphaTest(t){this._alphaTest>0!=t>0&&this.version++,this._alphaTest=t}onBeforeRender(){}onBeforeCompile(){}customProgramCacheKey(){return this.onBeforeCompile.toString()}setValues(t){if(t!==void 0)for(let n in t){let i=t[n];if(i===void 0){Ft(`Material: parameter '${n}' has value of undefined.`);continue}let r=this[n];if(r===void 0){Ft(`Material: '${n}' is not a property of THREE.${this.type}.`);continue}r&&r.isColor?r.set(i):r&&r.isVector2&&i&&i.isVector2||r&&r.isEuler&&i&&i.isEuler||r&&r.isVector3&&i&&i.isVector3?r.copy(i):this[n]=i}}toJSON(t){let n=t===void 0||typeof t=="string";n&&(t={textures:{},images:{}});let i={metadata:{version:4.7,type:"Material",generator:"Material.toJSON"}};i.uuid=this.uuid,i.type=this.type,i.blending=this.blending,i.side=this.side,i.shadowSide=this.shadowSide,i.vertexColors=this.vertexColors,i.opacity=this.opacity,i.transparent=this.transparent,i.blendSrc=this.blendSrc,i.blendDst=this.blendDst,i.blendEquation=this.blendEquation,i.blendSrcAlpha=this.blendSrcAlpha,i.blendDstAlpha=this.blendDstAlpha,i.blendEquationAlpha=this.blendEquationAlpha,i.blendColor=this.blendColor.getHex(),i.blendAlpha=this.blendAlpha,i.depthFunc=this.depthFunc,i.depthTest=this.depthTest,i.depthWrite=this.depthWrite,i.colorWrite=this.colorWrite,i.clipIntersection=this.clipIntersection,i.clipShadows=this.clipShadows,i.stencilWriteMask=this.stencilWriteMask,i.stencilFunc=this.stencilFunc,i.stencilRef=this.stencilRef,i.stencilFuncMask=this.stencilFuncMask,i.stencilFail=this.stencilFail,i.stencilZFail=this.stencilZFail,i.stencilZPass=this.stencilZPass,i.stencilWrite=this.stencilWrite,i.polygonOffset=this.polygonOffset,i.polygonOffsetFactor=this.polygonOffsetFactor,i.polygonOffsetUnits=this.polygonOffsetUnits,i.dithering=this.dithering,i.alphaTest=this.alphaTest,i.alphaHash=this.alphaHash,i.alphaToCoverage=this.alphaToCoverage,i.premultipliedAlpha=this.premultipliedAlpha,i.forceSinglePass=this.forceSinglePass,i.allowOverride=this.allowOverride,i.visible=this.visible,i.toneMapped=this.toneMapped,i.name=this.name,this.color&&this.color.isColor&&(i.color=this.color.getHex()),this.roughness!==void 0&&(i.roughness=this.roughness),this.metalness!==void 0&&(i.metalness=this.metalness),this.sheen!==void 0&&(i.sheen=this.sheen),this.sheenColor&&this.sheenColor.isColor&&(i.sheenColor=this.sheenColor.getHex()),this.sheenRoughness!==void 0&&(i.sheenRoughness=this.sheenRoughness),this.emissive&&this.emissive.isColor&&(i.emissive=this.emissive.getHex()),this.emissiveIntensity!==void 0&&(i.emissiveIntensity=this.emissiveIntensity),this.specular&&this.specular.isColor&&(i.specular=this.specular.getHex()),this.specularIntensity!==void 0&&(i.specularIntensity=this.specularIntensity),this.specularColor&&this.specularColor.isColor&&(i.specularColor=this.specularColor.getHex()),this.shininess!==void 0&&(i.shininess=this.shininess),this.clearcoat!==void 0&&(i.clearcoat=this.clearcoat),this.clearcoatRoughness!==void 0&&(i.clearcoatRoughness=this.clearcoatRoughness),this.diffuseRoughness!==void 0&&(i.diffuseRoughness=this.diffuseRoughness),this.diffuseRoughnessMap&&this.diffuseRoughnessMap.isTexture&&(i.diffuseRoughnessMap=this.diffuseRoughnessMap.toJSON(t).uuid),this.clearcoatMap&&this.clearcoatMap.isTexture&&(i.clearcoatMap=this.clearcoatMap.toJSON(t).uuid),this.clearcoatRoughnessMap&&this.clearcoatRoughnessMap.isTexture&&(i.clearcoatRoughnessMap=this.clearcoatRoughnessMap.toJSON(t).uuid),this.clearcoatNormalMap&&this.clearcoatNormalMap.isTexture&&(i.clearcoatNormalMap=this.clearcoatNormalMap.toJSON(t).uuid,i.clearcoatNormalScale=this.clearcoatNormalScale.toArray()),this.sheenColorMap&&this.sheenColorMap.isTexture&&(i.sheenColorMap=this.sheenColorMap.toJSON(t).uuid),this.sheenRoughnessMap&&this.sheenRoughnessMap.isTexture&&(i.sheenRoughnessMap=this.sheenRoughnessMap.toJSON(t).uuid),this.dispersion!==void 0&&(i.dispersion=this.dispersion),this.retroreflectivity!==void 0&&(i.retroreflectivity=this.retroreflectivity),this.iridescence!==void 0&&(i.iridescence=this.iridescence),this.iridescenceIOR!==void 0&&(i.iridescenceIOR=this.iridescenceIOR),this.iridescenceThicknessMinimum!==void 0&&(i.iridescenceThicknessMinimum=this.iridescenceThicknessMinimum),this.iridescenceThicknessMaximum!==void 0&&(i.iridescenceThicknessMaximum=this.iridescenceThicknessMaximum),this.iridescenceMap&&this.iridescenceMap.isTexture&&(i.iridescenceMap=this.iridescenceMap.toJSON(t).uuid),this.iridescenceThicknessMap&&this.iridescenceThicknessMap.isTexture&&(i.iridescenceThicknessMap=this.iridescenceThicknessMap.toJSON(t).uuid),this.anisotropy!==void 0&&(i.anisotropy=this.anisotropy),this.anisotropyRotation!==void 0&&(i.anisotropyRotation=this.anisotropyRotation),this.anisotropyMap&&this.anisotropyMap.isTexture&&(i.anisotropyMap=this.anisotropyMap.toJSON(t).uuid),this.map&&this.map.isTexture&&(i.map=this.map.toJSON(t).uuid),this.matcap&&this.matcap.isTexture&&(i.matcap=this.matcap.toJSON(t).uuid),this.alphaMap&&this.alphaMap.isTexture&&(i.alphaMap=this.alphaMap.toJSON(t).uuid),this.lightMap&&this.lightMap.isTexture&&(i.lightMap=this.lightMap.toJSON(t).uuid,i.lightMapIntensity=this.lightMapIntensity),this.aoMap&&this.aoMap.isTexture&&(i.aoMap=this.aoMap.toJSON(t).uuid,i.aoMapIntensity=this.aoMapIntensity),this.bumpMap&&this.bumpMap.isTexture&&(i.bumpMap=this.bumpMap.toJSON(t).uuid,i.bumpScale=this.bumpScale),this.normalMap&&this.normalMap.isTexture&&(i.normalMap=this.normalMap.toJSON(t).uuid,i.normalMapType=this.normalMapType,i.normalScale=this.normalScale.toArray()),this.displacementMap&&this.displacementMap.isTexture&&(i.displacementMap=this.displacementMap.toJSON(t).uuid,i.displacementScale=this.displacementScale,i.displacementBias=this.displacementBias),this.roughnessMap&&this.roughnessMap.isTexture&&(i.roughnessMap=this.roughnessMap.toJSON(t).uuid),this.metalnessMap&&this.metalnessMap.isTexture&&(i.metalnessMap=this.metalnessMap.toJSON(t).uuid),this.emissiveMap&&this.emissiveMap.isTexture&&(i.emissiveMap=this.emissiveMap.toJSON(t).uuid),this.specularMap&&this.specularMap.isTexture&&(i.specularMap=this.specularMap.toJSON(t).uuid),this.specularIntensityMap&&this.specularIntensityMap.isTexture&&(i.specularIntensityMap=this.specularIntensityMap.toJSON(t).uuid),this.specularColorMap&&this.specularColorMap.isTexture&&(i.specularColorMap=this.specularColorMap.toJSON(t).uuid),this.envMap&&this.envMap.isTexture&&(i.envMap=this.envMap.toJSON(t).uuid,this.combine!==void 0&&(i.combine=this.combine)),this.envMapRotation!==void 0&&(i.envMapRotation=this.envMapRotation.toArray()),this.envMapIntensity!==void 0&&(i.envMapIntensity=this.envMapIntensity),this.reflectivity!==void 0&&(i.reflectivity=this.reflectivity),this.refractionRatio!==void 0&&(i.refractionRatio=this.refractionRatio),this.gradientMap&&this.gradientMap.isTexture&&(i.gradientMap=this.gradientMap.toJSON(t).uuid),this.transmission!==void 0&&(i.transmission=this.transmission),this.transmissionMap&&this.transmissionMap.isTexture&&(i.transmissionMap=this.transmissionMap.toJSON(t).uuid),this.thickness!==void 0&&(i.thickness=this.thickness),this.thicknessMap&&this.thicknessMap.isTexture&&(i.thicknessMap=this.thicknessMap.toJSON(t).uuid),this.attenuationDistance!==void 0&&(i.attenuationDistance=this.attenuationDistance),this.attenuationColor!==void 0&&(i.attenuationColor=this.attenuationColor.getHex()),this.size!==void 0&&(i.size=this.size),this.sizeAttenuation!==void 0&&(i.sizeAttenuation=this.sizeAttenuation),Array.isArray(this.clippingPlanes)&&this.clippingPlanes.length>0&&(i.clippingPlanes=this.clippingPlanes.map(s=>s.toJSON())),this.rotation!==void 0&&(i.rotation=this.rotation),this.depthPacking!==void 0&&(i.depthPacking=this.depthPacking),this.linewidth!==void 0&&(i.linewidth=this.linewidth),this.linecap!==void 0&&(i.linecap=this.linecap),this.linejoin!==void 0&&(i.linejoin=this.linejoin),this.dashSize!==void 0&&(i.dashSize=this.dashSize),this.gapSize!==void 0&&(i.gapSize=this.gapSize),this.scale!==void 0&&(i.scale=this.scale),this.wireframe!==void 0&&(i.wireframe=this.wireframe),this.wireframeLinewidth!==void 0&&(i.wireframeLinewidth=this.wireframeLinewidth),this.wireframeLinecap!==void 0&&(i.wireframeLinecap=this.wireframeLinecap),this.wireframeLinejoin!==void 0&&(i.wireframeLinejoin=this.wireframeLinejoin),this.flatShading!==void 0&&(i.flatShading=this.flatShading),this.fog!==void 0&&(i.fog=this.fog),Object.keys(this.userData).length>0&&(i.userData=this.userData);function r(s){let o=[];for(let a in s){let c=s[a];delete c.metadata,o.push(c)}return o}if(n){let s=r(t.textures),o=r(t.images);s.length>0&&(i.textures=s),o.length>0&&(i.images=o)}return i}fromJSON(t,n){if(t.uuid!==void 0&&(this.uuid=t.uuid),t.name!==void 0&&(this.name=t.name),t.color!==void 0&&this.color!==void 0&&this.color.setHex(t.color),t.roughness!==void 0&&(this.roughness=t.roughness),t.metalness!==void 0&&(this.metalness=t.metalness),t.sheen!==void 0&&(this.sheen=t.sheen),t.sheenColor!==void 0&&(this.sheenColor=new Zt().setHex(t.sheenColor)),t.sheenRoughness!==void 0&&(this.sheenRoughness=t.sheenRoughness),t.emissive!==void 0&&this.emissive!==void 0&&this.emissive.setHex(t.emissive),t.specular!==void 0&&this.specular!==void 0&&this.specular.setHex(t.specular),t.specularIntensity!==void 0&&(this.specularIntensity=t.specularIntensity),t.specularColor!==void 0&&this.specularColor!==void 0&&this.specularColor.setHex(t.specularColor),t.shininess!==void 0&&(this.shininess=t.shininess),t.clearcoat!==void 0&&(this.clearcoat=t.clearcoat),t.clearcoatRoughness!==void 0&&(this.clearcoatRoughness=t.clearcoatRoughness),t.diffuseRoughness!==void 0&&(this.diffuseRoughness=t.diffuseRoughness),t.dispersion!==void 0&&(this.dispersion=t.dispersion),t.retroreflectivity!==void 0&&(this.retroreflectivity=t.retroreflectivity),t.iridescence!==void 0&&(this.iridescence=t.iridescence),t.iridescenceIOR!==void 0&&(this.iridescenceIOR=t.iridescenceIOR),t.iridescenceThicknessMinimum!==void 0&&(this.iridescenceThicknessMinimum=t.iridescenceThicknessMinimum),t.iridescenceThicknessMaximum!==void 0&&(this.iridescenceThicknessMaximum=t.iridescenceThicknessMaximum),t.iridescenceThicknessRange!==void 0&&(this.iridescenceThicknessMinimum=t.iridescenceThicknessRange[0],this.iridescenceThicknessMaximum=t.iridescenceThicknessRange[1]),t.transmission!==void 0&&(this.transmission=t.transmission),t.thickness!==void 0&&(this.thickness=t.thickness),t.attenuationDistance!==void 0&&(this.attenuationDistance=t.attenuationDistance),t.attenuationColor!==void 0&&this.attenuationColor!==void 0&&this.attenuationColor.setHex(t.attenuationColor),t.anisotropy!==void 0&&(this.anisotropy=t.anisotropy),t.anisotropyRotation!==void 0&&(this.anisotropyRotation=t.anisotropyRotation),t.fog!==void 0&&(this.fog=t.fog),t.flatShading!==void 0&&(this.flatShading=t.flatShading),t.blending!==void 0&&(this.blending=t.blending),t.combine!==void 0&&(this.combine=t.combine),t.side!==void 0&&(this.side=t.side),t.shadowSide!==void 0&&(this.shadowSide=t.shadowSide),t.opacity!==void 0&&(this.opacity=t.opacity),t.transparent!==void 0&&(this.transparent=t.transparent),t.alphaTest!==void 0&&(this.alphaTest=t.alphaTest),t.alphaHash!==void 0&&(this.alphaHash=t.alphaHash),t.depthFunc!==void 0&&(this.depthFunc=t.depthFunc),t.depthTest!==void 0&&(this.depthTest=t.depthTest),t.depthWrite!==void 0&&(this.depthWrite=t.depthWrite),t.colorWrite!==void 0&&(this.colorWrite=t.colorWrite),t.clippingPlanes!==void 0&&(this.clippingPlanes=t.clippingPlanes.map(i=>new Ei().fromJSON(i))),t.clipIntersection!==void 0&&(this.clipIntersection=t.clipIntersection),t.clipShadows!==void 0&&(this.clipShadows=t.clipShadows),t.depthPacking!==void 0&&(this.depthPacking=t.depthPacking),t.blendSrc!==void 0&&(this.blendSrc=t.blendSrc),t.blendDst!==void 0&&(this.blendDst=t.blendDst),t.blendEquation!==void 0&&(this.blendEquation=t.blendEquation),t.blendSrcAlpha!==void 0&&(this.blendSrcAlpha=t.blendSrcAlpha),t.blendDstAlpha!==void 0&&(this.blendDstAlpha=t.blendDstAlpha),t.blendEquationAlpha!==void 0&&(this.blendEquationAlpha=t.blendEquationAlpha),t.blendColor!==void 0&&this.blendColor!==void 0&&this.blendColor.setHex(t.blendColor),t.blendAlpha!==void 0&&(this.blendAlpha=t.blendAlpha),t.stencilWriteMask!==void 0&&(this.stencilWriteMask=t.stencilWriteMask),t.stencilFunc!==void 0&&(this.stencilFunc=t.stencilFunc),t.stencilRef!==void 0&&(this.stencilRef=t.stencilRef),t.stencilFuncMask!==void 0&&(this.stencilFuncMask=t.stencilFuncMask),t.stencilFail!==void 0&&(this.stencilFail=t.stencilFail),t.stencilZFail!==void 0&&(this.stencilZFail=t.stencilZFail),t.stencilZPass!==void 0&&(this.stencilZPass=t.stencilZPass),t.stencilWrite!==void 0&&(this.stencilWrite=t.stencilWrite),t.wireframe!==void 0&&(this.wireframe=t.wireframe),t.wireframeLinewidth!==void 0&&(this.wireframeLinewidth=t.wireframeLinewidth),t.wireframeLinecap!==void 0&&(this.wireframeLinecap=t.wireframeLinecap),t.wireframeLinejoin!==void 0&&(this.wireframeLinejoin=t.wireframeLinejoin),t.rotation!==void 0&&(this.rotation=t.rotation),t.linewidth!==void 0&&(this.linewidth=t.linewidth),t.linecap!==void 0&&(this.linecap=t.linecap),t.linejoin!==void 0&&(this.linejoin=t.linejoin),t.dashSize!==void 0&&(this.dashSize=t.dashSize),t.gapSize!==void 0&&(this.gapSize=t.gapSize),t.scale!==void 0&&(this.scale=t.scale),t.polygonOffset!==void 0&&(this.polygonOffset=t.polygonOffset),t.polygonOffsetFactor!==void 0&&(this.polygonOffsetFactor=t.polygonOffsetFactor),t.polygonOffsetUnits!==void 0&&(this.polygonOffsetUnits=t.polygonOffsetUnits),t.dithering!==void 0&&(this.dithering=t.dithering),t.alphaToCoverage!==void 0&&(this.alphaToCoverage=t.alphaToCoverage),t.premultipliedAlpha!==void 0&&(this.premultipliedAlpha=t.premultipliedAlpha),t.forceSinglePass!==void 0&&(this.forceSinglePass=t.forceSinglePass),t.allowOverride!==void 0&&(this.allowOverride=t.allowOverride),t.visible!==void 0&&(this.visible=t.visible),t.toneMapped!==void 0&&(this.toneMapped=t.toneMapped),t.userData!==void 0&&(this.userData=t.userData),t.vertexColors!==void 0&&(typeof t.vertexColors=="number"?this.vertexColors=t.vertexColors>0:this.vertexColors=t.vertexColors),t.size!==void 0&&(this.size=t.size),t.sizeAttenuation!==void 0&&(this.sizeAttenuation=t.sizeAttenuation),t.map!==void 0&&(this.map=n[t.map]||null),t.matcap!==void 0&&(this.matcap=n[t.matcap]||null),t.alphaMap!==void 0&&(this.alphaMap=n[t.alphaMap]||null),t.bumpMap!==void 0&&(this.bumpMap=n[t.bumpMap]||null),t.bumpScale!==void 0&&(this.bumpScale=t.bumpScale),t.normalMap!==void 0&&(this.normalMap=n[t.normalMap]||null),t.normalMapType!==void 0&&(this.normalMapType=t.normalMapType),t.normalScale!==void 0){let i=t.normalScale;Array.isArray(i)===!1&&(i=[i,i]),this.normalScale=new ie().fromArray(i)}return t.displacementMap!==void 0&&(this.displacementMap=n[t.displacementMap]||null),t.displacementScale!==void 0&&(this.displacementScale=t.displacementScale),t.displacementBias!==void 0&&(this.displacementBias=t.displacementBias),t.roughnessMap!==void 0&&(this.roughnessMap=n[t.roughnessMap]||null),t.metalnessMap!==void 0&&(this.metalnessMap=n[t.metalnessMap]||null),t.emissiveMap!==void 0&&(this.emissiveMap=n[t.emissiveMap]||null),t.emissiveIntensity!==void 0&&(this.emissiveIntensity=t.emissiveIntensity),t.specularMap!==void 0&&(this.specularMap=n[t.specularMap]||null),t.specularIntensityMap!==void 0&&(this.specularIntensityMap=n[t.specularIntensityMap]||null),t.specularColorMap!==void 0&&(this.specularColorMap=n[t.specularColorMap]||null),t.envMap!==void 0&&(this.envMap=n[t.envMap]||null),t.envMapRotation!==void 0&&this.envMapRotation.fromArray(t.envMapRotation),t.envMapIntensity!==void 0&&(this.envMapIntensity=t.envMapIntensity),t.reflectivity!==void 0&&(this.reflectivity=t.reflectivity),t.refractionRatio!==void 0&&(this.refractionRatio=t.refractionRatio),t.lightMap!==void 0&&(this.lightMap=n[t.lightMap]||null),t.lightMapIntensity!==void 0&&(this.lightMapIntensity=t.lightMapIntensity),t.aoMap!==void 0&&(this.aoMap=n[t.aoMap]||null),t.aoMapIntensity!==void 0&&(this.aoMapIntensity=t.aoMapIntensity),t.gradientMap!==void 0&&(this.gradientMap=n[t.gradientMap]||null),t.clearcoatMap!==void 0&&(this.clearcoatMap=n[t.clearcoatMap]||null),t.clearcoatRoughnessMap!==void 0&&(this.clearcoatRoughnessMap=n[t.clearcoatRoughnessMap]||null),t.clearcoatNormalMap!==void 0&&(this.clearcoatNormalMap=n[t.clearcoatNormalMap]||null),t.clearcoatNormalScale!==void 0&&(this.clearcoatNormalScale=new ie().fromArray(t.clearcoatNormalScale)),t.diffuseRoughnessMap!==void 0&&(this.diffuseRoughnessMap=n[t.diffuseRoughnessMap]||null),t.iridescenceMap!==void 0&&(this.iridescenceMap=n[t.iridescenceMap]||null),t.iridescenceThicknessMap!==void 0&&(this.iridescenceThicknessMap=n[t.iridescenceThicknessMap]||null),t.transmissionMap!==void 0&&(this.transmissionMap=n[t.transmissionMap]||null),t.thicknessMap!==void 0&&(this.thicknessMap=n[t.thicknessMap]||null),t.anisotropyMap!==void 0&&(this.anisotropyMap=n[t.anisotropyMap]||null),t.sheenColorMap!==void 0&&(this.sheenColorMap=n[t.sheenColorMap]||null),t.sheenRoughnessMap!==void 0&&(this.sheenRoughnessMap=n[t.sheenRoughnessMap]||null),this}clone(){return new this.constructor().copy(this)}copy(t){this.name=t.name,this.blending=t.blending,this.side=t.side,this.vertexColors=t.vertexColors,this.opacity=t.opacity,this.transparent=t.transparent,this.blendSrc=t.blendSrc,this.blendDst=t.blendDst,this.blendEquation=t.blendEquation,this.blendSrcAlpha=t.blendSrcAlpha,this.blendDstAlpha=t.blendDstAlpha,this.blendEquationAlpha=t.blendEquationAlpha,this.blendColor.copy(t.blendColor),this.blendAlpha=t.blendAlpha,this.depthFunc=t.depthFunc,this.depthTest=t.depthTest,this.depthWrite=t.depthWrite,this.stencilWriteMask=t.stencilWriteMask,this.stencilFunc=t.stencilFunc,this.stencilRef=t.stencilRef,this.stencilFuncMask=t.stencilFuncMask,this.stencilFail=t.stencilFail,this.stencilZFail=t.stencilZFail,this.stencilZPass=t.stencilZPass,this.stencilWrite=t.stencilWrite;let n=t.clippingPlanes,i=null;if(n!==null){let r=n.length;i=new Array(r);for(let s=0;s!==r;++s)i[s]=n[s].clone()}return this.clippingPlanes=i,this.clipIntersection=t.clipIntersection,this.clipShadows=t.clipShadows,this.shadowSide=t.shadowSide,this.colorWrite=t.colorWrite,this.precision=t.precision,this.polygonOffset=t.polygonOffset,this.polygonOffsetFactor=t.polygonOffsetFactor,this.polygonOffsetUnits=t.polygonOffsetUnits,this.dithering=t.dithering,this.alphaTest=t.alphaTest,this.alphaHash=t.alphaHash,this.alphaToCoverage=t.alphaToCoverage,this.premultipliedAlpha=t.premultipliedAlpha,this.forceSinglePass=t.forceSinglePass,this.allowOverride=t.allowOverride,this.visible=t.visible,this.toneMapped=t.toneMapped,this.userData=JSON.parse(JSON.stringify(t.userData)),this}dispose(){this.dispatchEvent({type:"dispose"})}set needsUpdate(t){t===!0&&this.version++}};var Tr=new W,zp=new W,xu=new W,_u=new W,Xu=class{constructor(t=new W,n=new W(0,0,-1)){this.origin=t,this.direction=n}set(t,n){return this.origin.copy(t),this.direction.copy(n),this}copy(t){return this.origin.copy(t.origin),this.direction.copy(t.direction),this}at(t,n){return n.copy(this.origin).addScaledVector(this.direction,t)}lookAt(t){return this.direction.copy(t).sub(this.origin).normalize(),this}recast(t){return this.origin.copy(this.at(t,Tr)),this}closestPointToPoint(t,n){n.subVectors(t,this.origin);let i=n.dot(this.direction);return i<0?n.copy(this.origin):n.copy(this.origin).addScaledVector(this.direction,i)}distanceToPoint(t){return Math.sqrt(this.distanceSqToPoint(t))}distanceSqToPoint(t){let n=Tr.subVectors(t,this.origin).dot(this.direction);return n<0?this.origin.distanceToSquared(t):(Tr.copy(this.origin).addScaledVector(this.direction,n),Tr.distanceToSquared(t))}distanceSqToSegment(t,n,i,r){zp.copy(t).add(n).multiplyScalar(.5),xu.copy(n).sub(t).normalize(),_u.copy(this.origin).sub(zp);let s=t.distanceTo(n)*.5,o=-this.direction.dot(xu),a=_u.dot(this.direction),c=-_u.dot(xu),l=_u.lengthSq(),u=Math.abs(1-o*o),h,f,d,p;if(u>0)if(h=o*c-a,f=o*a-c,p=s*u,h>=0)if(f>=-p)if(f<=p){let y=1/u;h*=y,f*=y,d=h*(h+o*f+2*a)+f*(o*h+f+2*c)+l}else f=s,h=Math.max(0,-(o*f+a)),d=-h*h+f*(f+2*c)+l;else f=-s,h=Math.max(0,-(o*f+a)),d=-h*h+f*(f+2*c)+l;else f<=-p?(h=Math.max(0,-(-o*s+a)),f=h>0?-s:Math.min(Math.max(-s,-c),s),d=-h*h+f*(f+2*c)+l):f<=p?(h=0,f=Math.min(Math.max(-s,-c),s),d=f*(f+2*c)+l):(h=Math.max(0,-(o*s+a)),f=h>0?s:Math.min(Math.max(-s,-c),s),d=-h*h+f*(f+2*c)+l);else f=o>0?-s:s,h=Math.max(0,-(o*f+a)),d=-h*h+f*(f+2*c)+l;return i&&i.copy(this.origin).addScaledVector(this.direction,h),r&&r.copy(zp).addScaledVector(xu,f),d}intersectSphere(t,n){if(t.radius<0)return null;Tr.subVectors(t.center,this.origin);let i=Tr.dot(this.direction),r=Tr.dot(Tr)-i*i,s=t.radius*t.radius;if(r>s)return null;let o=Math.sqrt(s-r),a=i-o,c=i+o;return c<0?null:a<0?this.at(c,n):this.at(a,n)}intersectsSphere(t){return t.radius<0?!1:this.distanceSqToPoint(t.center)<=t.radius*t.radius}distanceToPlane(t){let n=t.normal.dot(this.direction);if(n===0)return t.distanceToPoint(this.origin)===0?0:null;let i=-(this.origin.dot(t.normal)+t.constant)/n;return i>=0?i:null}intersectPlane(t,n){let i=this.distanceToPlane(t);return i===null?null:this.at(i,n)}intersectsPlane(t){let n=t.distanceToPoint(this.origin);return n===0||t.normal.dot(this.direction)*n<0}intersectBox(t,n){let i,r,s,o,a,c,l=1/this.direction.x,u=1/this.direction.y,h=1/this.direction.z,f=this.origin;return l>=0?(i=(t.min.x-f.x)*l,r=(t.max.x-f.x)*l):(i=(t.max.x-f.x)*l,r=(t.min.x-f.x)*l),u>=0?(s=(t.min.y-f.y)*u,o=(t.max.y-f.y)*u):(s=(t.max.y-f.y)*u,o=(t.min.y-f.y)*u),i>o||s>r||((s>i||isNaN(i))&&(i=s),(o<r||isNaN(r))&&(r=o),h>=0?(a=(t.min.z-f.z)*h,c=(t.max.z-f.z)*h):(a=(t.max.z-f.z)*h,c=(t.min.z-f.z)*h),i>c||a>r)||((a>i||i!==i)&&(i=a),(c<r||r!==r)&&(r=c),r<0)?null:this.at(i>=0?i:r,n)}intersectsBox(t){return this.intersectBox(t,Tr)!==null}intersectTriangle(t,n,i,r,s){let o=this.origin,a=this.direction,c=a.x,l=a.y,u=a.z,h=t.x-o.x,f=t.y-o.y,d=t.z-o.z,p=n.x-o.x,y=n.y-o.y,m=n.z-o.z,g=i.x-o.x,v=i.y-o.y,S=i.z-o.z,_=Math.abs(c),w=Math.abs(l),b=Math.abs(u),x,M,R,E,C,N,B,I,L,k,F,Z;if(_>=w&&_>=b?(R=c,N=h,L=p,Z=g,c>=0?(x=l,M=u,E=f,C=d,B=y,I=m,k=v,F=S):(x=u,M=l,E=d,C=f,B=m,I=y,k=S,F=v)):w>=b?(R=l,N=f,L=y,Z=v,l>=0?(x=u,M=c,E=d,C=h,B=m,I=p,k=S,F=g):(x=c,M=u,E=h,C=d,B=p,I=m,k=g,F=S)):(R=u,N=d,L=m,Z=S,u>=0?(x=c,M=l,E=h,C=f,B=p,I=y,k=g,F=v):(x=l,M=c,E=f,C=h,B=y,I=p,k=v,F=g)),R===0)return null;let U=x/R,G=M/R,q=1/R,st=E-U*N,ct=C-G*N,$=B-U*L,at=I-G*L,ft=k-U*Z,ot=F-G*Z,rt=ft*at-ot*$,J=st*ot-ct*ft,gt=$*ct-at*st;if(r){if(rt<0||J<0||gt<0)return null}else if((rt<0||J<0||gt<0)&&(rt>0||J>0||gt>0))return null;let lt=rt+J+gt;if(lt===0)return null;let K=q*(rt*N+J*L+gt*Z);return(lt>0?K<0:K>0)?null:this.at(K/lt,s)}applyMatrix4(t){return this.origin.applyMatrix4(t),this.direction.transformDirection(t),this}equals(t){return t.origin.equals(this.origin)&&t.direction.equals(this.direction)}clone(){return new this.constructor().copy(this)}},qu=class extends fs{constructor(t){super(),this.isMeshBasicMaterial=!0,this.type="MeshBasicMaterial",this.color=new Zt(16777215),this.map=null,this.lightMap=null,this.lightMapIntensity=1,this.aoMap=null,this.aoMapIntensity=1,this.specularMap=null,this.alphaMap=null,this.envMap=null,this.envMapRotation=new Rr,this.combine=hf,this.reflectivity=1,this.refractionRatio=.98,this.wireframe=!1,this.wireframeLinewidth=1,this.wireframeLinecap="round",this.wireframeLinejoin="round",this.fog=!0,this.setValues(t)}copy(t){return super.copy(t),this.color.copy(t.color),this.map=t.map,this.lightMap=t.lightMap,this.lightMapIntensity=t.lightMapIntensity,this.aoMap=t.aoMap,this.aoMapIntensity=t.aoMapIntensity,this.specularMap=t.specularMap,this.alphaMap=t.alphaMap,this.envMap=t.envMap,this.envMapRotation.copy(t.envMapRotation),this.combine=t.combine,this.reflectivity=t.reflectivity,this.refractionRatio=t.refractionRatio,this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this.wireframeLinecap=t.wireframeLinecap,this.wireframeLinejoin=t.wireframeLinejoin,this.fog=t.fog,this}},hv=new we,Xs=new Xu,vu=new Qo,dv=new W,bu=new W,Mu=new W,Su=new W,Gp=new W,wu=new W,pv=new W,Tu=new W,Yn=class extends wn{constructor(t=new ri,n=new qu){super(),this.isMesh=!0,this.type="Mesh",this.geometry=t,this.material=n,this.morphTargetDictionary=void 0,this.morphTargetInfluences=void 0,this.count=1,this.updateMorphTargets()}copy(t,n){return super.copy(t,n),t.morphTargetInfluences!==void 0?this.morphTargetInfluences=t.morphTargetInfluences.slice():this.morphTargetInfluences=void 0,t.morphTargetDictionary!==void 0?this.morphTargetDictionary=Object.assign({},t.morphTargetDictionary):this.morphTargetDictionary=void 0,this.material=Array.isArray(t.material)?t.material.slice():t.material,this.geometry=t.geometry,this}updateMorphTargets(){let n=this.geometry.morphAttributes,i=Object.keys(n);if(i.length>0){let r=n[i[0]];if(r!==void 0){this.morphTargetInfluences=[],this.morphTargetDictionary={};for(let s=0,o=r.length;s<o;s++){let a=r[s].name||String(s);this.morphTargetInfluences.push(0),this.morphTargetDictionary[a]=s}}}}getVertexPosition(t,n){let i=this.geometry,r=i.attributes.position,s=i.morphAttributes.position,o=i.morphTargetsRelative;n.fromBufferAttribute(r,t);let a=this.morphTargetInfluences;if(s&&a){wu.set(0,0,0);for(let c=0,l=s.length;c<l;c++){let u=a[c],h=s[c];u!==0&&(Gp.fromBufferAttribute(h,t),o?wu.addScaledVector(Gp,u):wu.addScaledVector(Gp.sub(n),u))}n.add(wu)}return n}intersectsFrustum(t){return t.intersectsObject(this)}raycast(t,n){let i=this.geometry,r=this.material,s=this.matrixWorld;r!==void 0&&(i.boundingSphere===null&&i.computeBoundingSphere(),vu.copy(i.boundingSphere),vu.applyMatrix4(s),Xs.copy(t.ray).recast(t.near),!(vu.containsPoint(Xs.origin)===!1&&(Xs.intersectSphere(vu,dv)===null||Xs.origin.distanceToSquared(dv)>(t.far-t.near)**2))&&(hv.copy(s).invert(),Xs.copy(t.ray).applyMatrix4(hv),!(i.boundingBox!==null&&Xs.intersectsBox(i.boundingBox)===!1)&&this._computeIntersections(t,n,Xs)))}_computeIntersections(t,n,i){let r,s=this.geometry,o=this.material,a=s.index,c=s.attributes.position,l=s.attributes.uv,u=s.attributes.uv1,h=s.attributes.normal,f=s.groups,d=s.drawRange;if(a!==null)if(Array.isArray(o))for(let p=0,y=f.length;p<y;p++){let m=f[p],g=o[m.materialIndex],v=Math.max(m.start,d.start),S=Math.min(a.count,Math.min(m.start+m.count,d.start+d.count));for(let _=v,w=S;_<w;_+=3){let b=a.getX(_),x=a.getX(_+1),M=a.getX(_+2);r=Au(this,g,t,i,l,u,h,b,x,M),r&&(r.faceIndex=Math.floor(_/3),r.face.materialIndex=m.materialIndex,n.push(r))}}else{let p=Math.max(0,d.start),y=Math.min(a.count,d.start+d.count);for(let m=p,g=y;m<g;m+=3){let v=a.getX(m),S=a.getX(m+1),_=a.getX(m+2);r=Au(this,o,t,i,l,u,h,v,S,_),r&&(r.faceIndex=Math.floor(m/3),n.push(r))}}else if(c!==void 0)if(Array.isArray(o))for(let p=0,y=f.length;p<y;p++){let m=f[p],g=o[m.materialIndex],v=Math.max(m.start,d.start),S=Math.min(c.count,Math.min(m.start+m.count,d.start+d.count));for(let _=v,w=S;_<w;_+=3){let b=_,x=_+1,M=_+2;r=Au(this,g,t,i,l,u,h,b,x,M),r&&(r.faceIndex=Math.floor(_/3),r.face.materialIndex=m.materialIndex,n.push(r))}}else{let p=Math.max(0,d.start),y=Math.min(c.count,d.start+d.count);for(let m=p,g=y;m<g;m+=3){let v=m,S=m+1,_=m+2;r=Au(this,o,t,i,l,u,h,v,S,_),r&&(r.faceIndex=Math.floor(m/3),n.push(r))}}}};function hC(e,t,n,i,r,s,o,a){let c;if(t.side===Tn?c=i.intersectTriangle(o,s,r,!0,a):c=i.intersectTriangle(r,s,o,t.side===ys,a),c===null)return null;Tu.copy(a),Tu.applyMatrix4(e.matrixWorld);let l=n.ray.origin.distanceTo(Tu);return l<n.near||l>n.far?null:{distance:l,point:Tu.clone(),object:e}}function Au(e,t,n,i,r,s,o,a,c,l){e.getVertexPosition(a,bu),e.getVertexPosition(c,Mu),e.getVertexPosition(l,Su);let u=hC(e,t,n,i,bu,Mu,Su,pv);if(u){let h=new W;us.getBarycoord(pv,bu,Mu,Su,h),r&&(u.uv=us.getInterpolatedAttribute(r,a,c,l,h,new ie)),s&&(u.uv1=us.getInterpolatedAttribute(s,a,c,l,h,new ie)),o&&(u.normal=us.getInterpolatedAttribute(o,a,c,l,h,new W),u.normal.dot(i.direction)>0&&u.normal.multiplyScalar(-1));let f={a,b:c,c:l,normal:new W,materialIndex:0};us.getNormal(bu,Mu,Su,f.normal),u.face=f,u.barycoord=h}return u}var Yu=class extends Fn{constructor(t=null,n=1,i=1,r,s,o,a,c,l=je,u=je,h,f){super(null,o,a,c,l,u,r,s,h,f),this.isDataTexture=!0,this.image={data:t,width:n,height:i},this.generateMipmaps=!1,this.flipY=!1,this.unpackAlignment=1}};var qs=new Qo,dC=new ie(.5,.5),Eu=new W,hs=class{constructor(t=new Ei,n=new Ei,i=new Ei,r=new Ei,s=new Ei,o=new Ei){this.planes=[t,n,i,r,s,o]}set(t,n,i,r,s,o){let a=this.planes;return a[0].copy(t),a[1].copy(n),a[2].copy(i),a[3].copy(r),a[4].copy(s),a[5].copy(o),this}copy(t){let n=this.planes;for(let i=0;i<6;i++)n[i].copy(t.planes[i]);return this}setFromProjectionMatrix(t,n=ii,i=!1){let r=this.planes,s=t.elements,o=s[0],a=s[1],c=s[2],l=s[3],u=s[4],h=s[5],f=s[6],d=s[7],p=s[8],y=s[9],m=s[10],g=s[11],v=s[12],S=s[13],_=s[14],w=s[15];if(r[0].setComponents(l-o,d-u,g-p,w-v).normalize(),r[1].setComponents(l+o,d+u,g+p,w+v).normalize(),r[2].setComponents(l+a,d+h,g+y,w+S).normalize(),r[3].setComponents(l-a,d-h,g-y,w-S).normalize(),i)r[4].setComponents(c,f,m,_).normalize(),r[5].setComponents(l-c,d-f,g-m,w-_).normalize();else if(r[4].setComponents(l-c,d-f,g-m,w-_).normalize(),n===ii)r[5].setComponents(l+c,d+f,g+m,w+_).normalize();else if(n===Yo)r[5].setComponents(c,f,m,_).normalize();else throw new Error("THREE.Frustum.setFromProjectionMatrix(): Invalid coordinate system: "+n);return this}intersectsObject(t){if(t.boundingSphere!==void 0)t.boundingSphere===null&&t.computeBoundingSphere(),qs.copy(t.boundingSphere).applyMatrix4(t.matrixWorld);else{let n=t.geometry;n.boundingSphere===null&&n.computeBoundingSphere(),qs.copy(n.boundingSphere).applyMatrix4(t.matrixWorld)}return this.intersectsSphere(qs)}intersectsSprite(t){qs.center.set(0,0,0);let n=dC.distanceTo(t.center);return qs.radius=.7071067811865476+n,qs.applyMatrix4(t.matrixWorld),this.intersectsSphere(qs)}intersectsSphere(t){let n=this.planes,i=t.center,r=-t.radius;for(let s=0;s<6;s++)if(n[s].distanceToPoint(i)<r)return!1;return!0}intersectsBox(t){let n=this.planes;for(let i=0;i<6;i++){let r=n[i];if(Eu.x=r.normal.x>0?t.max.x:t.min.x,Eu.y=r.normal.y>0?t.max.y:t.min.y,Eu.z=r.normal.z>0?t.max.z:t.min.z,r.distanceToPoint(Eu)<0)return!1}return!0}containsPoint(t){let n=this.planes;for(let i=0;i<6;i++)if(n[i].distanceToPoint(t)<0)return!1;return!0}clone(){return new this.constructor().copy(this)}},mv=new we,Zu=class e{constructor(){this.coordinateSystem=ii,this._frustums=[],this._count=0}setFromArrayCamera(t){let n=t.cameras,i=this._frustums;for(let r=0;r<n.length;r++){let s=n[r];mv.multiplyMatrices(s.projectionMatrix,s.matrixWorldInverse),i[r]===void 0&&(i[r]=new hs),i[r].setFromProjectionMatrix(mv,s.coordinateSystem,s.reversedDepth)}return this._count=n.length,this}getFrustum(t){return this._frustums[t]}intersectsObject(t){let n=this._frustums;for(let i=0;i<this._count;i++)if(n[i].intersectsObject(t))return!0;return!1}intersectsSprite(t){let n=this._frustums;for(let i=0;i<this._count;i++)if(n[i].intersectsSprite(t))return!0;return!1}intersectsSphere(t){let n=this._frustums;for(let i=0;i<this._count;i++)if(n[i].intersectsSphere(t))return!0;return!1}intersectsBox(t){let n=this._frustums;for(let i=0;i<this._count;i++)if(n[i].intersectsBox(t))return!0;return!1}containsPoint(t){let n=this._frustums;for(let i=0;i<this._count;i++)if(n[i].containsPoint(t))return!0;return!1}copy(t){this.coordinateSystem=t.coordinateSystem;let n=this._frustums,i=t._frustums;for(let r=0;r<t._count;r++)n[r]===void 0&&(n[r]=new hs),n[r].copy(i[r]);return this._count=t._count,this}clone(){return new e().copy(this)}};var Cc=class extends Fn{constructor(t=[],n=Ks,i,r,s,o,a,c,l,u){super(t,n,i,r,s,o,a,c,l,u),this.isCubeTexture=!0,this.flipY=!1}get images(){return this.image}set images(t){this.image=t}};var Ir=class extends Fn{constructor(t,n,i=Ci,r,s,o,a=je,c=je,l,u=Cr,h=1){if(u!==Cr&&u!==Lr)throw new Error("THREE.DepthTexture: format must be either THREE.DepthFormat or THREE.DepthStencilFormat");let f={width:t,height:n,depth:h};super(f,r,s,o,a,c,u,i,l),this.isDepthTexture=!0,this.flipY=!1,this.generateMipmaps=!1,this.compareFunction=null}copy(t){return super.copy(t),this.source=new Ko(Object.assign({},t.image)),this.compareFunction=t.compareFunction,this}toJSON(t){let n=super.toJSON(t);return n.compareFunction=this.compareFunction,n}},Rc=class extends Ir{constructor(t,n=Ci,i=Ks,r,s,o=je,a=je,c,l=Cr){let u={width:t,height:t,depth:1},h=[u,u,u,u,u,u];super(t,t,n,i,r,s,o,a,c,l),this.image=h,this.isCubeDepthTexture=!0,this.isCubeTexture=!0}get images(){return this.image}set images(t){this.image=t}},Ic=class extends Fn{constructor(t=null){super(),this.sourceTexture=t,this.isExternalTexture=!0}copy(t){return super.copy(t),this.sourceTexture=t.sourceTexture,this}},ds=class e extends ri{constructor(t=1,n=1,i=1,r=1,s=1,o=1){super(),this.type="BoxGeometry",this.parameters={width:t,height:n,depth:i,widthSegments:r,heightSegments:s,depthSegments:o};let a=this;r=Math.floor(r),s=Math.floor(s),o=Math.floor(o);let c=[],l=[],u=[],h=[],f=0,d=0;p("z","y","x",-1,-1,i,n,t,o,s,0),p("z","y","x",1,-1,i,n,-t,o,s,1),p("x","z","y",1,1,t,i,n,r,o,2),p("x","z","y",1,-1,t,i,-n,r,o,3),p("x","y","z",1,-1,t,n,i,r,s,4),p("x","y","z",-1,-1,t,n,-i,r,s,5),this.setIndex(c),this.setAttribute("position",new Ke(l,3)),this.setAttribute("normal",new Ke(u,3)),this.setAttribute("uv",new Ke(h,2));function p(y,m,g,v,S,_,w,b,x,M,R){let E=_/x,C=w/M,N=_/2,B=w/2,I=b/2,L=x+1,k=M+1,F=0,Z=0,U=new W;for(let G=0;G<k;G++){let q=G*C-B;for(let st=0;st<L;st++){let ct=st*E-N;U[y]=ct*v,U[m]=q*S,U[g]=I,l.push(U.x,U.y,U.z),U[y]=0,U[m]=0,U[g]=b>0?1:-1,u.push(U.x,U.y,U.z),h.push(st/x),h.push(1-G/M),F+=1}}for(let G=0;G<M;G++)for(let q=0;q<x;q++){let st=f+q+L*G,ct=f+q+L*(G+1),$=f+(q+1)+L*(G+1),at=f+(q+1)+L*G;c.push(st,ct,at),c.push(ct,$,at),Z+=6}a.addGroup(d,Z,R),d+=Z,f+=F}}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new e(t.width,t.height,t.depth,t.widthSegments,t.heightSegments,t.depthSegments)}};var Pc=class e extends ri{constructor(t=1,n=1,i=1,r=32,s=1,o=!1,a=0,c=Math.PI*2){super(),this.type="CylinderGeometry",this.parameters={radiusTop:t,radiusBottom:n,height:i,radialSegments:r,heightSegments:s,openEnded:o,thetaStart:a,thetaLength:c};let l=this;r=Math.floor(r),s=Math.floor(s);let u=[],h=[],f=[],d=[],p=0,y=[],m=i/2,g=0;v(),o===!1&&(t>0&&S(!0),n>0&&S(!1)),this.setIndex(u),this.setAttribute("position",new Ke(h,3)),this.setAttribute("normal",new Ke(f,3)),this.setAttribute("uv",new Ke(d,2));function v(){let _=new W,w=new W,b=0,x=(n-t)/i;for(let M=0;M<=s;M++){let R=[],E=M/s,C=E*(n-t)+t;for(let N=0;N<=r;N++){let B=N/r,I=B*c+a,L=Math.sin(I),k=Math.cos(I);w.x=C*L,w.y=-E*i+m,w.z=C*k,h.push(w.x,w.y,w.z),_.set(L,x,k).normalize(),f.push(_.x,_.y,_.z),d.push(B,1-E),R.push(p++)}y.push(R)}for(let M=0;M<r;M++)for(let R=0;R<s;R++){let E=y[R][M],C=y[R+1][M],N=y[R+1][M+1],B=y[R][M+1];(t>0||R!==0)&&(u.push(E,C,B),b+=3),(n>0||R!==s-1)&&(u.push(C,N,B),b+=3)}l.addGroup(g,b,0),g+=b}function S(_){let w=p,b=new ie,x=new W,M=0,R=_===!0?t:n,E=_===!0?1:-1;for(let N=1;N<=r;N++)h.push(0,m*E,0),f.push(0,E,0),d.push(.5,.5),p++;let C=p;for(let N=0;N<=r;N++){let I=N/r*c+a,L=Math.cos(I),k=Math.sin(I);x.x=R*k,x.y=m*E,x.z=R*L,h.push(x.x,x.y,x.z),f.push(0,E,0),b.x=L*.5+.5,b.y=k*.5*E+.5,d.push(b.x,b.y),p++}for(let N=0;N<r;N++){let B=w+N,I=C+N;_===!0?u.push(I,I+1,B):u.push(I+1,I,B),M+=3}l.addGroup(g,M,_===!0?1:2),g+=M}}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new e(t.radiusTop,t.radiusBottom,t.height,t.radialSegments,t.heightSegments,t.openEnded,t.thetaStart,t.thetaLength)}};var Ys=class e extends ri{constructor(t=1,n=1,i=1,r=1){super(),this.type="PlaneGeometry",this.parameters={width:t,height:n,widthSegments:i,heightSegments:r};let s=t/2,o=n/2,a=Math.floor(i),c=Math.floor(r),l=a+1,u=c+1,h=t/a,f=n/c,d=[],p=[],y=[],m=[];for(let g=0;g<u;g++){let v=g*f-o;for(let S=0;S<l;S++){let _=S*h-s;p.push(_,-v,0),y.push(0,0,1),m.push(S/a),m.push(1-g/c)}}for(let g=0;g<c;g++)for(let v=0;v<a;v++){let S=v+l*g,_=v+l*(g+1),w=v+1+l*(g+1),b=v+1+l*g;d.push(S,_,b),d.push(_,w,b)}this.setIndex(d),this.setAttribute("position",new Ke(p,3)),this.setAttribute("normal",new Ke(y,3)),this.setAttribute("uv",new Ke(m,2))}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new e(t.width,t.height,t.widthSegments,t.heightSegments)}};var Lc=class e extends ri{constructor(t=1,n=32,i=16,r=0,s=Math.PI*2,o=0,a=Math.PI){super(),this.type="SphereGeometry",this.parameters={radius:t,widthSegments:n,heightSegments:i,phiStart:r,phiLength:s,thetaStart:o,thetaLength:a},n=Math.max(3,Math.floor(n)),i=Math.max(2,Math.floor(i));let c=Math.min(o+a,Math.PI),l=0,u=[],h=new W,f=new W,d=[],p=[],y=[],m=[];for(let g=0;g<=i;g++){let v=[],S=g/i,_=o+S*a,w=t*Math.cos(_),b=Math.sqrt(t*t-w*w),x=0;g===0&&o===0?x=.5/n:g===i&&c===Math.PI&&(x=-.5/n);for(let M=0;M<=n;M++){let R=M/n,E=r+R*s;h.x=-b*Math.cos(E),h.y=w,h.z=b*Math.sin(E),p.push(h.x,h.y,h.z),f.copy(h).normalize(),y.push(f.x,f.y,f.z),m.push(R+x,1-S),v.push(l++)}u.push(v)}for(let g=0;g<i;g++)for(let v=0;v<n;v++){let S=u[g][v+1],_=u[g][v],w=u[g+1][v],b=u[g+1][v+1];(g!==0||o>0)&&d.push(S,_,b),(g!==i-1||c<Math.PI)&&d.push(_,w,b)}this.setIndex(d),this.setAttribute("position",new Ke(p,3)),this.setAttribute("normal",new Ke(y,3)),this.setAttribute("uv",new Ke(m,2))}copy(t){return super.copy(t),this.parameters=Object.assign({},t.parameters),this}static fromJSON(t){return new e(t.radius,t.widthSegments,t.heightSegments,t.phiStart,t.phiLength,t.thetaStart,t.thetaLength)}};function Qs(e){let t={};for(let n in e){t[n]={};for(let i in e[n]){let r=e[n][i];if(gv(r))r.isRenderTargetTexture?(Ft("UniformsUtils: Textures of render targets cannot be cloned via cloneUniforms() or mergeUniforms()."),t[n][i]=null):t[n][i]=r.clone();else if(Array.isArray(r))if(gv(r[0])){let s=[];for(let o=0,a=r.length;o<a;o++)s[o]=r[o].clone();t[n][i]=s}else t[n][i]=r.slice();else t[n][i]=r}}return t}function mn(e){let t={};for(let n=0;n<e.length;n++){let i=Qs(e[n]);for(let r in i)t[r]=i[r]}return t}function gv(e){return e&&(e.isColor||e.isMatrix3||e.isMatrix4||e.isVector2||e.isVector3||e.isVector4||e.isTexture||e.isQuaternion)}function pC(e){let t=[];for(let n=0;n<e.length;n++)t.push(e[n].clone());return t}function Am(e){let t=e.getRenderTarget();return t===null?e.outputColorSpace:t.isXRRenderTarget===!0?t.texture.colorSpace:ee.workingColorSpace}var lb={clone:Qs,merge:mn},mC=`void main() {
	gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 );
}`,gC=`void main() {
	gl_FragColor = vec4( 1.0, 0.0, 0.0, 1.0 );
}`,qi=class extends fs{constructor(t){super(),this.isShaderMaterial=!0,this.type="ShaderMaterial",this.defines={},this.uniforms={},this.uniformsGroups=[],this.vertexShader=mC,this.fragmentShader=gC,this.linewidth=1,this.wireframe=!1,this.wireframeLinewidth=1,this.fog=!1,this.lights=!1,this.clipping=!1,this.forceSinglePass=!0,this.extensions={clipCullDistance:!1,multiDraw:!1},this.defaultAttributeValues={color:[1,1,1],uv:[0,0],uv1:[0,0]},this.index0AttributeName=void 0,this.uniformsNeedUpdate=!1,this.glslVersion=null,t!==void 0&&this.setValues(t)}copy(t){return super.copy(t),this.fragmentShader=t.fragmentShader,this.vertexShader=t.vertexShader,this.uniforms=Qs(t.uniforms),this.uniformsGroups=pC(t.uniformsGroups),this.defines=Object.assign({},t.defines),this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this.fog=t.fog,this.lights=t.lights,this.clipping=t.clipping,this.extensions=Object.assign({},t.extensions),this.glslVersion=t.glslVersion,this.defaultAttributeValues=Object.assign({},t.defaultAttributeValues),this.index0AttributeName=t.index0AttributeName,this.uniformsNeedUpdate=t.uniformsNeedUpdate,this}toJSON(t){let n=super.toJSON(t);n.glslVersion=this.glslVersion,n.uniforms={};for(let r in this.uniforms){let o=this.uniforms[r].value;o&&o.isTexture?n.uniforms[r]={type:"t",value:o.toJSON(t).uuid}:o&&o.isColor?n.uniforms[r]={type:"c",value:o.getHex()}:o&&o.isVector2?n.uniforms[r]={type:"v2",value:o.toArray()}:o&&o.isVector3?n.uniforms[r]={type:"v3",value:o.toArray()}:o&&o.isVector4?n.uniforms[r]={type:"v4",value:o.toArray()}:o&&o.isMatrix3?n.uniforms[r]={type:"m3",value:o.toArray()}:o&&o.isMatrix4?n.uniforms[r]={type:"m4",value:o.toArray()}:n.uniforms[r]={value:o}}Object.keys(this.defines).length>0&&(n.defines=this.defines),n.vertexShader=this.vertexShader,n.fragmentShader=this.fragmentShader,n.lights=this.lights,n.clipping=this.clipping;let i={};for(let r in this.extensions)this.extensions[r]===!0&&(i[r]=!0);return Object.keys(i).length>0&&(n.extensions=i),n}fromJSON(t,n){if(super.fromJSON(t,n),t.uniforms!==void 0)for(let i in t.uniforms){let r=t.uniforms[i];switch(this.uniforms[i]={},r.type){case"t":this.uniforms[i].value=n[r.value]||null;break;case"c":this.uniforms[i].value=new Zt().setHex(r.value);break;case"v2":this.uniforms[i].value=new ie().fromArray(r.value);break;case"v3":this.uniforms[i].value=new W().fromArray(r.value);break;case"v4":this.uniforms[i].value=new Te().fromArray(r.value);break;case"m3":this.uniforms[i].value=new zt().fromArray(r.value);break;case"m4":this.uniforms[i].value=new we().fromArray(r.value);break;default:this.uniforms[i].value=r.value}}if(t.defines!==void 0&&(this.defines=t.defines),t.vertexShader!==void 0&&(this.vertexShader=t.vertexShader),t.fragmentShader!==void 0&&(this.fragmentShader=t.fragmentShader),t.glslVersion!==void 0&&(this.glslVersion=t.glslVersion),t.extensions!==void 0)for(let i in t.extensions)this.extensions[i]=t.extensions[i];return t.lights!==void 0&&(this.lights=t.lights),t.clipping!==void 0&&(this.clipping=t.clipping),this}},Ju=class extends qi{constructor(t){super(t),this.isRawShaderMaterial=!0,this.type="RawShaderMaterial"}};var ta=class extends fs{constructor(t){super(),this.isMeshLambertMaterial=!0,this.type="MeshLambertMaterial",this.color=new Zt(16777215),this.map=null,this.lightMap=null,this.lightMapIntensity=1,this.aoMap=null,this.aoMapIntensity=1,this.emissive=new Zt(0),this.emissiveIntensity=1,this.emissiveMap=null,this.bumpMap=null,this.bumpScale=1,this.normalMap=null,this.normalMapType=jf,this.normalScale=new ie(1,1),this.displacementMap=null,this.displacementScale=1,this.displacementBias=0,this.specularMap=null,this.alphaMap=null,this.envMap=null,this.envMapRotation=new Rr,this.combine=hf,this.reflectivity=1,this.envMapIntensity=1,this.refractionRatio=.98,this.wireframe=!1,this.wireframeLinewidth=1,this.wireframeLinecap="round",this.wireframeLinejoin="round",this.flatShading=!1,this.fog=!0,this.setValues(t)}copy(t){return super.copy(t),this.color.copy(t.color),this.map=t.map,this.lightMap=t.lightMap,this.lightMapIntensity=t.lightMapIntensity,this.aoMap=t.aoMap,this.aoMapIntensity=t.aoMapIntensity,this.emissive.copy(t.emissive),this.emissiveMap=t.emissiveMap,this.emissiveIntensity=t.emissiveIntensity,this.bumpMap=t.bumpMap,this.bumpScale=t.bumpScale,this.normalMap=t.normalMap,this.normalMapType=t.normalMapType,this.normalScale.copy(t.normalScale),this.displacementMap=t.displacementMap,this.displacementScale=t.displacementScale,this.displacementBias=t.displacementBias,this.specularMap=t.specularMap,this.alphaMap=t.alphaMap,this.envMap=t.envMap,this.envMapRotation.copy(t.envMapRotation),this.combine=t.combine,this.reflectivity=t.reflectivity,this.envMapIntensity=t.envMapIntensity,this.refractionRatio=t.refractionRatio,this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this.wireframeLinecap=t.wireframeLinecap,this.wireframeLinejoin=t.wireframeLinejoin,this.flatShading=t.flatShading,this.fog=t.fog,this}},Ku=class extends fs{constructor(t){super(),this.isMeshDepthMaterial=!0,this.type="MeshDepthMaterial",this.depthPacking=qv,this.map=null,this.alphaMap=null,this.displacementMap=null,this.displacementScale=1,this.displacementBias=0,this.wireframe=!1,this.wireframeLinewidth=1,this.setValues(t)}copy(t){return super.copy(t),this.depthPacking=t.depthPacking,this.map=t.map,this.alphaMap=t.alphaMap,this.displacementMap=t.displacementMap,this.displacementScale=t.displacementScale,this.displacementBias=t.displacementBias,this.wireframe=t.wireframe,this.wireframeLinewidth=t.wireframeLinewidth,this}},ju=class extends fs{constructor(t){super(),this.isMeshDistanceMaterial=!0,this.type="MeshDistanceMaterial",this.map=null,this.alphaMap=null,this.displacementMap=null,this.displacementScale=1,this.displacementBias=0,this.setValues(t)}copy(t){return super.copy(t),this.map=t.map,this.alphaMap=t.alphaMap,this.displacementMap=t.displacementMap,this.displacementScale=t.displacementScale,this.displacementBias=t.displacementBias,this}};function Ho(e,t){return!e||e.constructor===t?e:typeof t.BYTES_PER_ELEMENT=="number"?new t(e):Array.prototype.slice.call(e)}function Cu(e){return e!==void 0&&e.inTangents!==void 0&&e.outTangents!==void 0}var ps=class{constructor(t,n,i,r){this.parameterPositions=t,this._cachedIndex=0,this.resultBuffer=r!==void 0?r:new n.constructor(i),this.sampleValues=n,this.valueSize=i,this.settings=null,this.DefaultSettings_={}}evaluate(t){let n=this.parameterPositions,i=this._cachedIndex,r=n[i],s=n[i-1];t:{e:{let o;n:{i:if(!(t<r)){for(let a=i+2;;){if(r===void 0){if(t<s)break i;return i=n.length,this._cachedIndex=i,this.copySampleValue_(i-1)}if(i===a)break;if(s=r,r=n[++i],t<r)break e}o=n.length;break n}if(!(t>=s)){let a=n[1];t<a&&(i=2,s=a);for(let c=i-2;;){if(s===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(i===c)break;if(r=s,s=n[--i-1],t>=s)break e}o=i,i=0;break n}break t}for(;i<o;){let a=i+o>>>1;t<n[a]?o=a:i=a+1}if(r=n[i],s=n[i-1],s===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(r===void 0)return i=n.length,this._cachedIndex=i,this.copySampleValue_(i-1)}this._cachedIndex=i,this.intervalChanged_(i,s,r)}return this.interpolate_(i,s,t,r)}getSettings_(){return this.settings||this.DefaultSettings_}copySampleValue_(t){let n=this.resultBuffer,i=this.sampleValues,r=this.valueSize,s=t*r;for(let o=0;o!==r;++o)n[o]=i[s+o];return n}interpolate_(){throw new Error("THREE.Interpolant: Call to abstract method.")}intervalChanged_(){}},Qu=class extends ps{constructor(t,n,i,r){super(t,n,i,r),this._weightPrev=-0,this._offsetPrev=-0,this._weightNext=-0,this._offsetNext=-0,this.DefaultSettings_={endingStart:Wp,endingEnd:Wp}}intervalChanged_(t,n,i){let r=this.parameterPositions,s=t-2,o=t+1,a=r[s],c=r[o];if(a===void 0)switch(this.getSettings_().endingStart){case $p:s=t,a=2*n-i;break;case Xp:s=r.length-2,a=n+r[s]-r[s+1];break;default:s=t,a=i}if(c===void 0)switch(this.getSettings_().endingEnd){case $p:o=t,c=2*i-n;break;case Xp:o=1,c=i+r[1]-r[0];break;default:o=t-1,c=n}let l=(i-n)*.5,u=this.valueSize;this._weightPrev=l/(n-a),this._weightNext=l/(c-i),this._offsetPrev=s*u,this._offsetNext=o*u}interpolate_(t,n,i,r){let s=this.resultBuffer,o=this.sampleValues,a=this.valueSize,c=t*a,l=c-a,u=this._offsetPrev,h=this._offsetNext,f=this._weightPrev,d=this._weightNext,p=(i-n)/(r-n),y=p*p,m=y*p,g=-f*m+2*f*y-f*p,v=(1+f)*m+(-1.5-2*f)*y+(-.5+f)*p+1,S=(-1-d)*m+(1.5+d)*y+.5*p,_=d*m-d*y;for(let w=0;w!==a;++w)s[w]=g*o[u+w]+v*o[l+w]+S*o[c+w]+_*o[h+w];return s}},tf=class extends ps{constructor(t,n,i,r){super(t,n,i,r)}interpolate_(t,n,i,r){let s=this.resultBuffer,o=this.sampleValues,a=this.valueSize,c=t*a,l=c-a,u=(i-n)/(r-n),h=1-u;for(let f=0;f!==a;++f)s[f]=o[l+f]*h+o[c+f]*u;return s}},ef=class extends ps{constructor(t,n,i,r){super(t,n,i,r)}interpolate_(t){return this.copySampleValue_(t-1)}},nf=class extends ps{interpolate_(t,n,i,r){let s=this.resultBuffer,o=this.sampleValues,a=this.valueSize,c=t*a,l=c-a,u=this.inTangents,h=this.outTangents;if(!u||!h){let p=(i-n)/(r-n),y=1-p;for(let m=0;m!==a;++m)s[m]=o[l+m]*y+o[c+m]*p;return s}let f=a*2,d=t-1;for(let p=0;p!==a;++p){let y=o[l+p],m=o[c+p],g=d*f+p*2,v=h[g],S=h[g+1],_=t*f+p*2,w=u[_],b=u[_+1],x=xC(i,n,v,w,r);s[p]=ub(x,y,S,b,m)}return s}};function ub(e,t,n,i,r){let s=1-e;return s*s*s*t+3*s*s*e*n+3*s*e*e*i+e*e*e*r}function yC(e,t,n,i,r){let s=1-e;return 3*s*s*(n-t)+6*s*e*(i-n)+3*e*e*(r-i)}function xC(e,t,n,i,r){let s=(e-t)/(r-t);for(let o=0;o<8;o++){let a=ub(s,t,n,i,r)-e;if(Math.abs(a)<1e-10)break;let c=yC(s,t,n,i,r);if(Math.abs(c)<1e-10)break;s=Math.max(0,Math.min(1,s-a/c))}return s}var Zn=class{constructor(t,n,i,r){if(t===void 0)throw new Error("THREE.KeyframeTrack: track name is undefined");if(n===void 0||n.length===0)throw new Error("THREE.KeyframeTrack: no keyframes in track named "+t);this.name=t,this.times=Ho(n,this.TimeBufferType),this.values=Ho(i,this.ValueBufferType),this.setInterpolation(r||this.DefaultInterpolation)}static toJSON(t){let n=t.constructor,i;if(n.toJSON!==this.toJSON)i=n.toJSON(t);else{i={name:t.name,times:Ho(t.times,Array),values:Ho(t.values,Array)};let r=t.getInterpolation();r!==t.DefaultInterpolation&&(i.interpolation=r),Cu(t.settings)&&(i.settings={inTangents:Ho(t.settings.inTangents,Array),outTangents:Ho(t.settings.outTangents,Array)})}return i.type=t.ValueTypeName,i}InterpolantFactoryMethodDiscrete(t){return new ef(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodLinear(t){return new tf(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodSmooth(t){return new Qu(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodBezier(t){let n=new nf(this.times,this.values,this.getValueSize(),t);return this.settings&&(n.inTangents=this.settings.inTangents,n.outTangents=this.settings.outTangents),n}setInterpolation(t){let n;switch(t){case _c:n=this.InterpolantFactoryMethodDiscrete;break;case Vu:n=this.InterpolantFactoryMethodLinear;break;case Pu:n=this.InterpolantFactoryMethodSmooth;break;case Hp:n=this.InterpolantFactoryMethodBezier;break}if(n===void 0){let i="unsupported interpolation for "+this.ValueTypeName+" keyframe track named "+this.name;if(this.createInterpolant===void 0)if(t!==this.DefaultInterpolation)this.setInterpolation(this.DefaultInterpolation);else throw new Error(i);return Ft("KeyframeTrack:",i),this}return this.createInterpolant=n,this}getInterpolation(){switch(this.createInterpolant){case this.InterpolantFactoryMethodDiscrete:return _c;case this.InterpolantFactoryMethodLinear:return Vu;case this.InterpolantFactoryMethodSmooth:return Pu;case this.InterpolantFactoryMethodBezier:return Hp}}getValueSize(){return this.values.length/this.times.length}shift(t){if(t!==0){let n=this.times;for(let i=0,r=n.length;i!==r;++i)n[i]+=t;Cu(this.settings)&&(yv(this.settings.inTangents,t),yv(this.settings.outTangents,t))}return this}scale(t){if(t!==1){let n=this.times;for(let i=0,r=n.length;i!==r;++i)n[i]*=t;Cu(this.settings)&&(xv(this.settings.inTangents,t),xv(this.settings.outTangents,t))}return this}trim(t,n){let i=this.times,r=i.length,s=0,o=r-1;for(;s!==r&&i[s]<t;)++s;for(;o!==-1&&i[o]>n;)--o;if(++o,s!==0||o!==r){s>=o&&(o=Math.max(o,1),s=o-1);let a=this.getValueSize();this.times=i.slice(s,o),this.values=this.values.slice(s*a,o*a)}return this}validate(){let t=!0,n=this.getValueSize();n-Math.floor(n)!==0&&(kt("KeyframeTrack: Invalid value size in track.",this),t=!1);let i=this.times,r=this.values,s=i.length;s===0&&(kt("KeyframeTrack: Track is empty.",this),t=!1);let o=null;for(let a=0;a!==s;a++){let c=i[a];if(typeof c=="number"&&isNaN(c)){kt("KeyframeTrack: Time is not a valid number.",this,a,c),t=!1;break}if(o!==null&&o>c){kt("KeyframeTrack: Out of order keys.",this,a,c,o),t=!1;break}o=c}if(r!==void 0&&D3(r))for(let a=0,c=r.length;a!==c;++a){let l=r[a];if(isNaN(l)){kt("KeyframeTrack: Value is not a valid number.",this,a,l),t=!1;break}}return t}optimize(){let t=this.times.slice(),n=this.values.slice(),i=this.getValueSize(),r=this.getInterpolation()===Pu,s=t.length-1,o=1;for(let a=1;a<s;++a){let c=!1,l=t[a],u=t[a+1];if(l!==u&&(a!==1||l!==t[0]))if(r)c=!0;else{let h=a*i,f=h-i,d=h+i;for(let p=0;p!==i;++p){let y=n[h+p];if(y!==n[f+p]||y!==n[d+p]){c=!0;break}}}if(c){if(a!==o){t[o]=t[a];let h=a*i,f=o*i;for(let d=0;d!==i;++d)n[f+d]=n[h+d]}++o}}if(s>0){t[o]=t[s];for(let a=s*i,c=o*i,l=0;l!==i;++l)n[c+l]=n[a+l];++o}return o!==t.length?(this.times=t.slice(0,o),this.values=n.slice(0,o*i)):(this.times=t,this.values=n),this}clone(){let t=this.times.slice(),n=this.values.slice(),i=this.constructor,r=new i(this.name,t,n);return r.createInterpolant=this.createInterpolant,Cu(this.settings)&&(r.settings={inTangents:this.settings.inTangents.slice(),outTangents:this.settings.outTangents.slice()}),r}};function yv(e,t){for(let n=0,i=e.length;n!==i;n+=2)e[n]+=t}function xv(e,t){for(let n=0,i=e.length;n!==i;n+=2)e[n]*=t}Zn.prototype.ValueTypeName="";Zn.prototype.TimeBufferType=Float32Array;Zn.prototype.ValueBufferType=Float32Array;Zn.prototype.DefaultInterpolation=Vu;var ms=class extends Zn{constructor(t,n,i){super(t,n,i)}};ms.prototype.ValueTypeName="bool";ms.prototype.ValueBufferType=Array;ms.prototype.DefaultInterpolation=_c;ms.prototype.InterpolantFactoryMethodLinear=void 0;ms.prototype.InterpolantFactoryMethodSmooth=void 0;var rf=class extends Zn{constructor(t,n,i,r){super(t,n,i,r)}};rf.prototype.ValueTypeName="color";var sf=class extends Zn{constructor(t,n,i,r){super(t,n,i,r)}};sf.prototype.ValueTypeName="number";var of=class extends ps{constructor(t,n,i,r){super(t,n,i,r)}interpolate_(t,n,i,r){let s=this.resultBuffer,o=this.sampleValues,a=this.valueSize,c=(i-n)/(r-n),l=t*a;for(let u=l+a;l!==u;l+=4)Sn.slerpFlat(s,0,o,l-a,o,l,c);return s}},Nc=class extends Zn{constructor(t,n,i,r){super(t,n,i,r)}InterpolantFactoryMethodLinear(t){return new of(this.times,this.values,this.getValueSize(),t)}};Nc.prototype.ValueTypeName="quaternion";Nc.prototype.InterpolantFactoryMethodSmooth=void 0;var gs=class extends Zn{constructor(t,n,i){super(t,n,i)}};gs.prototype.ValueTypeName="string";gs.prototype.ValueBufferType=Array;gs.prototype.DefaultInterpolation=_c;gs.prototype.InterpolantFactoryMethodLinear=void 0;gs.prototype.InterpolantFactoryMethodSmooth=void 0;var af=class extends Zn{constructor(t,n,i,r){super(t,n,i,r)}};af.prototype.ValueTypeName="vector";var cf=class{constructor(t,n,i){let r=this,s=!1,o=0,a=0,c,l=[];this.onStart=void 0,this.onLoad=t,this.onProgress=n,this.onError=i,this._abortController=null,this.itemStart=function(u){a++,s===!1&&r.onStart!==void 0&&r.onStart(u,o,a),s=!0},this.itemEnd=function(u){o++,r.onProgress!==void 0&&r.onProgress(u,o,a),o===a&&(s=!1,r.onLoad!==void 0&&r.onLoad())},this.itemError=function(u){r.onError!==void 0&&r.onError(u)},this.resolveURL=function(u){return u=u.normalize("NFC"),c?c(u):u},this.setURLModifier=function(u){return c=u,this},this.addHandler=function(u,h){return l.push(u,h),this},this.removeHandler=function(u){let h=l.indexOf(u);return h!==-1&&l.splice(h,2),this},this.getHandler=function(u){for(let h=0,f=l.length;h<f;h+=2){let d=l[h],p=l[h+1];if(d.global&&(d.lastIndex=0),d.test(u))return p}return null},this.abort=function(){return this.abortController.abort(),this._abortController=null,this}}get abortController(){return this._abortController||(this._abortController=new AbortController),this._abortController}},fb=new cf,lf=class{constructor(t){this.manager=t!==void 0?t:fb,this.crossOrigin="anonymous",this.withCredentials=!1,this.path="",this.resourcePath="",this.requestHeader={},this.priority="auto",this.cache="default",typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}load(){}loadAsync(t,n){let i=this;return new Promise(function(r,s){i.load(t,r,n,s)})}parse(){}setCrossOrigin(t){return this.crossOrigin=t,this}setWithCredentials(t){return this.withCredentials=t,this}setPath(t){return this.path=t,this}setResourcePath(t){return this.resourcePath=t,this}setRequestHeader(t){return this.requestHeader=t,this}setPriority(t){return this.priority=t,this}setCache(t){return this.cache=t,this}abort(){return this}};lf.DEFAULT_MATERIAL_NAME="__DEFAULT";var Dc=class extends wn{static registerNode(t){this.prototype._lightNode=t}constructor(t,n=1){super(),this.isLight=!0,this.type="Light",this.color=new Zt(t),this.intensity=n}copy(t,n){return super.copy(t,n),this.color.copy(t.color),this.intensity=t.intensity,this}toJSON(t){let n=super.toJSON(t);return n.object.color=this.color.getHex(),n.object.intensity=this.intensity,n}};var Vp=new we,_v=new W,vv=new W,uf=class{constructor(t){this.camera=t,this.intensity=1,this.bias=0,this.biasNode=null,this.normalBias=0,this.radius=1,this.blurSamples=8,this.mapSize=new ie(512,512),this.mapType=On,this.map=null,this.mapPass=null,this.matrix=new we,this.autoUpdate=!0,this.needsUpdate=!1,this._frustum=new hs,this._frameExtents=new ie(1,1),this._viewportCount=1,this._viewports=[new Te(0,0,1,1)]}getViewportCount(){return this._viewportCount}getCamera(){return this.camera}getFrustum(){return this._frustum}updateMatrices(t){let n=this.camera;_v.setFromMatrixPosition(t.matrixWorld),n.position.copy(_v),vv.setFromMatrixPosition(t.target.matrixWorld),n.lookAt(vv),n.updateMatrixWorld(),this._updateMatrix(n,this.matrix,this._frustum)}_updateMatrix(t,n,i,r){Vp.multiplyMatrices(t.projectionMatrix,t.matrixWorldInverse),i.setFromProjectionMatrix(Vp,t.coordinateSystem,t.reversedDepth);let s=this._frameExtents,o=r?r.z/s.x:1,a=r?r.w/s.y:1,c=r?r.x/s.x:0,l=r?r.y/s.y:0;t.coordinateSystem===Yo||t.reversedDepth?n.set(.5*o,0,0,.5*o+c,0,.5*a,0,.5*a+l,0,0,1,0,0,0,0,1):n.set(.5*o,0,0,.5*o+c,0,.5*a,0,.5*a+l,0,0,.5,.5,0,0,0,1),n.multiply(Vp)}getViewport(t){return this._viewports[t]}getFrameExtents(){return this._frameExtents}dispose(){this.map&&this.map.dispose(),this.mapPass&&this.mapPass.dispose()}copy(t){return this.camera=t.camera.clone(),this.intensity=t.intensity,this.bias=t.bias,this.radius=t.radius,this.autoUpdate=t.autoUpdate,this.needsUpdate=t.needsUpdate,this.normalBias=t.normalBias,this.blurSamples=t.blurSamples,this.mapSize.copy(t.mapSize),this.mapType=t.mapType,this.biasNode=t.biasNode,this}clone(){return new this.constructor().copy(this)}toJSON(){let t={};return t.intensity=this.intensity,t.bias=this.bias,t.normalBias=this.normalBias,t.radius=this.radius,t.blurSamples=this.blurSamples,t.mapSize=this.mapSize.toArray(),t.mapType=this.mapType,t.camera=this.camera.toJSON(!1).object,delete t.camera.matrix,t}},Ru=new W,Iu=new Sn,Wi=new W,Fc=class extends wn{constructor(){super(),this.isCamera=!0,this.type="Camera",this.matrixWorldInverse=new we,this.projectionMatrix=new we,this.projectionMatrixInverse=new we,this.coordinateSystem=ii,this._reversedDepth=!1}get reversedDepth(){return this._reversedDepth}copy(t,n){return super.copy(t,n),this.matrixWorldInverse.copy(t.matrixWorldInverse),this.projectionMatrix.copy(t.projectionMatrix),this.projectionMatrixInverse.copy(t.projectionMatrixInverse),this.coordinateSystem=t.coordinateSystem,this}getWorldDirection(t){return super.getWorldDirection(t).negate()}updateMatrixWorld(t){super.updateMatrixWorld(t),this.matrixWorld.decompose(Ru,Iu,Wi),Wi.x===1&&Wi.y===1&&Wi.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose(Ru,Iu,Wi.set(1,1,1)).invert()}updateWorldMatrix(t,n,i=!1){super.updateWorldMatrix(t,n,i),this.matrixWorld.decompose(Ru,Iu,Wi),Wi.x===1&&Wi.y===1&&Wi.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose(Ru,Iu,Wi.set(1,1,1)).invert()}clone(){return new this.constructor().copy(this)}},ls=new W,bv=new ie,Mv=new ie,vn=class extends Fc{constructor(t=50,n=1,i=.1,r=2e3){super(),this.isPerspectiveCamera=!0,this.type="PerspectiveCamera",this.fov=t,this.zoom=1,this.near=i,this.far=r,this.focus=10,this.aspect=n,this.view=null,this.filmGauge=35,this.filmOffset=0,this.updateProjectionMatrix()}copy(t,n){return super.copy(t,n),this.fov=t.fov,this.zoom=t.zoom,this.near=t.near,this.far=t.far,this.focus=t.focus,this.aspect=t.aspect,this.view=t.view===null?null:Object.assign({},t.view),this.filmGauge=t.filmGauge,this.filmOffset=t.filmOffset,this}setFocalLength(t){let n=.5*this.getFilmHeight()/t;this.fov=Jo*2*Math.atan(n),this.updateProjectionMatrix()}getFocalLength(){let t=Math.tan(yc*.5*this.fov);return .5*this.getFilmHeight()/t}getEffectiveFOV(){return Jo*2*Math.atan(Math.tan(yc*.5*this.fov)/this.zoom)}getFilmWidth(){return this.filmGauge*Math.min(this.aspect,1)}getFilmHeight(){return this.filmGauge/Math.max(this.aspect,1)}getViewBounds(t,n,i){ls.set(-1,-1,.5).applyMatrix4(this.projectionMatrixInverse),n.set(ls.x,ls.y).multiplyScalar(-t/ls.z),ls.set(1,1,.5).applyMatrix4(this.projectionMatrixInverse),i.set(ls.x,ls.y).multiplyScalar(-t/ls.z)}getViewSize(t,n){return this.getViewBounds(t,bv,Mv),n.subVectors(Mv,bv)}setViewOffset(t,n,i,r,s,o){this.aspect=t/n,this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=n,this.view.offsetX=i,this.view.offsetY=r,this.view.width=s,this.view.height=o,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=this.near,n=t*Math.tan(yc*.5*this.fov)/this.zoom,i=2*n,r=this.aspect*i,s=-.5*r,o=this.view;if(this.view!==null&&this.view.enabled){let c=o.fullWidth,l=o.fullHeight;s+=o.offsetX*r/c,n-=o.offsetY*i/l,r*=o.width/c,i*=o.height/l}let a=this.filmOffset;a!==0&&(s+=t*a/this.getFilmWidth()),this.projectionMatrix.makePerspective(s,s+r,n,n-i,t,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let n=super.toJSON(t);return n.object.fov=this.fov,n.object.zoom=this.zoom,n.object.near=this.near,n.object.far=this.far,n.object.focus=this.focus,n.object.aspect=this.aspect,this.view!==null&&(n.object.view=Object.assign({},this.view)),n.object.filmGauge=this.filmGauge,n.object.filmOffset=this.filmOffset,n}};var Uc=class extends Fc{constructor(t=-1,n=1,i=1,r=-1,s=.1,o=2e3){super(),this.isOrthographicCamera=!0,this.type="OrthographicCamera",this.zoom=1,this.view=null,this.left=t,this.right=n,this.top=i,this.bottom=r,this.near=s,this.far=o,this.updateProjectionMatrix()}copy(t,n){return super.copy(t,n),this.left=t.left,this.right=t.right,this.top=t.top,this.bottom=t.bottom,this.near=t.near,this.far=t.far,this.zoom=t.zoom,this.view=t.view===null?null:Object.assign({},t.view),this}setViewOffset(t,n,i,r,s,o){this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=n,this.view.offsetX=i,this.view.offsetY=r,this.view.width=s,this.view.height=o,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=(this.right-this.left)/(2*this.zoom),n=(this.top-this.bottom)/(2*this.zoom),i=(this.right+this.left)/2,r=(this.top+this.bottom)/2,s=i-t,o=i+t,a=r+n,c=r-n;if(this.view!==null&&this.view.enabled){let l=(this.right-this.left)/this.view.fullWidth/this.zoom,u=(this.top-this.bottom)/this.view.fullHeight/this.zoom;s+=l*this.view.offsetX,o=s+l*this.view.width,a-=u*this.view.offsetY,c=a-u*this.view.height}this.projectionMatrix.makeOrthographic(s,o,a,c,this.near,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let n=super.toJSON(t);return n.object.zoom=this.zoom,n.object.left=this.left,n.object.right=this.right,n.object.top=this.top,n.object.bottom=this.bottom,n.object.near=this.near,n.object.far=this.far,this.view!==null&&(n.object.view=Object.assign({},this.view)),n}},qp=class extends uf{constructor(){super(new Uc(-5,5,5,-5,.5,500)),this.isDirectionalLightShadow=!0}},Oc=class extends Dc{constructor(t,n){super(t,n),this.isDirectionalLight=!0,this.type="DirectionalLight",this.position.copy(wn.DEFAULT_UP),this.updateMatrix(),this.target=new wn,this.shadow=new qp}dispose(){super.dispose(),this.shadow.dispose()}copy(t){return super.copy(t),this.target=t.target.clone(),this.shadow=t.shadow.clone(),this}toJSON(t){let n=super.toJSON(t);return n.object.shadow=this.shadow.toJSON(),n.object.target=this.target.uuid,n}},Bc=class extends Dc{constructor(t,n){super(t,n),this.isAmbientLight=!0,this.type="AmbientLight"}};var Wo=-90,$o=1,ea=class extends wn{constructor(t,n,i){super(),this.type="CubeCamera",this.renderTarget=i,this.coordinateSystem=null,this.activeMipmapLevel=0;let r=new vn(Wo,$o,t,n);r.layers=this.layers,this.add(r);let s=new vn(Wo,$o,t,n);s.layers=this.layers,this.add(s);let o=new vn(Wo,$o,t,n);o.layers=this.layers,this.add(o);let a=new vn(Wo,$o,t,n);a.layers=this.layers,this.add(a);let c=new vn(Wo,$o,t,n);c.layers=this.layers,this.add(c);let l=new vn(Wo,$o,t,n);l.layers=this.layers,this.add(l)}updateCoordinateSystem(){let t=this.coordinateSystem,n=this.children.concat(),[i,r,s,o,a,c]=n;for(let l of n)this.remove(l);if(t===ii)i.up.set(0,1,0),i.lookAt(1,0,0),r.up.set(0,1,0),r.lookAt(-1,0,0),s.up.set(0,0,-1),s.lookAt(0,1,0),o.up.set(0,0,1),o.lookAt(0,-1,0),a.up.set(0,1,0),a.lookAt(0,0,1),c.up.set(0,1,0),c.lookAt(0,0,-1);else if(t===Yo)i.up.set(0,-1,0),i.lookAt(-1,0,0),r.up.set(0,-1,0),r.lookAt(1,0,0),s.up.set(0,0,1),s.lookAt(0,1,0),o.up.set(0,0,-1),o.lookAt(0,-1,0),a.up.set(0,-1,0),a.lookAt(0,0,1),c.up.set(0,-1,0),c.lookAt(0,0,-1);else throw new Error("THREE.CubeCamera.updateCoordinateSystem(): Invalid coordinate system: "+t);for(let l of n)this.add(l),l.updateMatrixWorld()}update(t,n){this.parent===null&&this.updateMatrixWorld();let{renderTarget:i,activeMipmapLevel:r}=this;this.coordinateSystem!==t.coordinateSystem&&(this.coordinateSystem=t.coordinateSystem,this.updateCoordinateSystem());let[s,o,a,c,l,u]=this.children,h=t.getRenderTarget(),f=t.getActiveCubeFace(),d=t.getActiveMipmapLevel(),p=t.xr.enabled;t.xr.enabled=!1;let y=i.texture.mipmapsAutoUpdate;i.texture.mipmapsAutoUpdate=!1;let m=!1;t.isWebGLRenderer===!0?m=t.state.buffers.depth.getReversed():m=t.reversedDepthBuffer,t.setRenderTarget(i,0,r),m&&t.autoClear===!1&&t.clearDepth(),t.render(n,s),t.setRenderTarget(i,1,r),m&&t.autoClear===!1&&t.clearDepth(),t.render(n,o),t.setRenderTarget(i,2,r),m&&t.autoClear===!1&&t.clearDepth(),t.render(n,a),t.setRenderTarget(i,3,r),m&&t.autoClear===!1&&t.clearDepth(),t.render(n,c),t.setRenderTarget(i,4,r),m&&t.autoClear===!1&&t.clearDepth(),t.render(n,l),i.texture.mipmapsAutoUpdate=y,t.setRenderTarget(i,5,r),m&&t.autoClear===!1&&t.clearDepth(),t.render(n,u),t.setRenderTarget(h,f,d),t.xr.enabled=p,i.texture.needsPMREMUpdate=!0}},ff=class extends vn{constructor(t=[]){super(),this.isArrayCamera=!0,this.isMultiViewCamera=!1,this.cameras=t,this.perCameraFrustumCulled=!1}};var Em="\\[\\]\\.:\\/",_C=new RegExp("["+Em+"]","g"),Cm="[^"+Em+"]",vC="[^"+Em.replace("\\.","")+"]",bC=/((?:WC+[\/:])*)/.source.replace("WC",Cm),MC=/(WCOD+)?/.source.replace("WCOD",vC),SC=/(?:\.(WC+)(?:\[(.+)\])?)?/.source.replace("WC",Cm),wC=/\.(WC+)(?:\[(.+)\])?/.source.replace("WC",Cm),TC=new RegExp("^"+bC+MC+SC+wC+"$"),AC=["material","materials","bones","map"],Yp=class{constructor(t,n,i){let r=i||Me.parseTrackName(n);this._targetGroup=t,this._bindings=t.subscribe_(n,r)}getValue(t,n){this.bind();let i=this._targetGroup.nCachedObjects_,r=this._bindings[i];r!==void 0&&r.getValue(t,n)}setValue(t,n){let i=this._bindings;for(let r=this._targetGroup.nCachedObjects_,s=i.length;r!==s;++r)i[r].setValue(t,n)}bind(){let t=this._bindings;for(let n=this._targetGroup.nCachedObjects_,i=t.length;n!==i;++n)t[n].bind()}unbind(){let t=this._bindings;for(let n=this._targetGroup.nCachedObjects_,i=t.length;n!==i;++n)t[n].unbind()}},Me=class e{constructor(t,n,i){this.path=n,this.parsedPath=i||e.parseTrackName(n),this.node=e.findNode(t,this.parsedPath.nodeName),this.rootNode=t,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}static create(t,n,i){return t&&t.isAnimationObjectGroup?new e.Composite(t,n,i):new e(t,n,i)}static sanitizeNodeName(t){return t.replace(/\s/g,"_").replace(_C,"")}static parseTrackName(t){let n=TC.exec(t);if(n===null)throw new Error("THREE.PropertyBinding: Cannot parse trackName: "+t);let i={nodeName:n[2],objectName:n[3],objectIndex:n[4],propertyName:n[5],propertyIndex:n[6]},r=i.nodeName&&i.nodeName.lastIndexOf(".");if(r!==void 0&&r!==-1){let s=i.nodeName.substring(r+1);AC.indexOf(s)!==-1&&(i.nodeName=i.nodeName.substring(0,r),i.objectName=s)}if(i.propertyName===null||i.propertyName.length===0)throw new Error("THREE.PropertyBinding: can not parse propertyName from trackName: "+t);return i}static findNode(t,n){if(n===void 0||n===""||n==="."||n===-1||n===t.name||n===t.uuid)return t;if(t.skeleton){let i=t.skeleton.getBoneByName(n);if(i!==void 0)return i}if(t.children){let i=function(s){for(let o=0;o<s.length;o++){let a=s[o];if(a.name===n||a.uuid===n)return a;let c=i(a.children);if(c)return c}return null},r=i(t.children);if(r)return r}return null}_getValue_unavailable(){}_setValue_unavailable(){}_getValue_direct(t,n){t[n]=this.targetObject[this.propertyName]}_getValue_array(t,n){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)t[n++]=i[r]}_getValue_arrayElement(t,n){t[n]=this.resolvedProperty[this.propertyIndex]}_getValue_toArray(t,n){this.resolvedProperty.toArray(t,n)}_setValue_direct(t,n){this.targetObject[this.propertyName]=t[n]}_setValue_direct_setNeedsUpdate(t,n){this.targetObject[this.propertyName]=t[n],this.targetObject.needsUpdate=!0}_setValue_direct_setMatrixWorldNeedsUpdate(t,n){this.targetObject[this.propertyName]=t[n],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_array(t,n){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[n++]}_setValue_array_setNeedsUpdate(t,n){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[n++];this.targetObject.needsUpdate=!0}_setValue_array_setMatrixWorldNeedsUpdate(t,n){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[n++];this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_arrayElement(t,n){this.resolvedProperty[this.propertyIndex]=t[n]}_setValue_arrayElement_setNeedsUpdate(t,n){this.resolvedProperty[this.propertyIndex]=t[n],this.targetObject.needsUpdate=!0}_setValue_arrayElement_setMatrixWorldNeedsUpdate(t,n){this.resolvedProperty[this.propertyIndex]=t[n],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_fromArray(t,n){this.resolvedProperty.fromArray(t,n)}_setValue_fromArray_setNeedsUpdate(t,n){this.resolvedProperty.fromArray(t,n),this.targetObject.needsUpdate=!0}_setValue_fromArray_setMatrixWorldNeedsUpdate(t,n){this.resolvedProperty.fromArray(t,n),this.targetObject.matrixWorldNeedsUpdate=!0}_getValue_unbound(t,n){this.bind(),this.getValue(t,n)}_setValue_unbound(t,n){this.bind(),this.setValue(t,n)}bind(){let t=this.node,n=this.parsedPath,i=n.objectName,r=n.propertyName,s=n.propertyIndex;if(t||(t=e.findNode(this.rootNode,n.nodeName),this.node=t),this.getValue=this._getValue_unavailable,this.setValue=this._setValue_unavailable,!t){Ft("PropertyBinding: No target node found for track: "+this.path+".");return}if(i){let l=n.objectIndex;switch(i){case"materials":if(!t.material){kt("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.materials){kt("PropertyBinding: Can not bind to material.materials as node.material does not have a materials array.",this);return}t=t.material.materials;break;case"bones":if(!t.skeleton){kt("PropertyBinding: Can not bind to bones as node does not have a skeleton.",this);return}t=t.skeleton.bones;for(let u=0;u<t.length;u++)if(t[u].name===l){l=u;break}break;case"map":if("map"in t){t=t.map;break}if(!t.material){kt("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.map){kt("PropertyBinding: Can not bind to material.map as node.material does not have a map.",this);return}t=t.material.map;break;default:if(t[i]===void 0){kt("PropertyBinding: Can not bind to objectName of node undefined.",this);return}t=t[i]}if(l!==void 0){if(t[l]===void 0){kt("PropertyBinding: Trying to bind to objectIndex of objectName, but is undefined.",this,t);return}t=t[l]}}let o=t[r];if(o===void 0){let l=n.nodeName;kt("PropertyBinding: Trying to update property for track: "+l+"."+r+" but it wasn't found.",t);return}let a=this.Versioning.None;this.targetObject=t,t.isMaterial===!0?a=this.Versioning.NeedsUpdate:t.isObject3D===!0&&(a=this.Versioning.MatrixWorldNeedsUpdate);let c=this.BindingType.Direct;if(s!==void 0){if(r==="morphTargetInfluences"){if(!t.geometry){kt("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.",this);return}if(!t.geometry.morphAttributes){kt("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.morphAttributes.",this);return}t.morphTargetDictionary[s]!==void 0&&(s=t.morphTargetDictionary[s])}c=this.BindingType.ArrayElement,this.resolvedProperty=o,this.propertyIndex=s}else o.fromArray!==void 0&&o.toArray!==void 0?(c=this.BindingType.HasFromToArray,this.resolvedProperty=o):Array.isArray(o)?(c=this.BindingType.EntireArray,this.resolvedProperty=o):this.propertyName=r;this.getValue=this.GetterByBindingType[c],this.setValue=this.SetterByBindingTypeAndVersioning[c][a]}unbind(){this.node=null,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}};Me.Composite=Yp;Me.prototype.BindingType={Direct:0,EntireArray:1,ArrayElement:2,HasFromToArray:3};Me.prototype.Versioning={None:0,NeedsUpdate:1,MatrixWorldNeedsUpdate:2};Me.prototype.GetterByBindingType=[Me.prototype._getValue_direct,Me.prototype._getValue_array,Me.prototype._getValue_arrayElement,Me.prototype._getValue_toArray];Me.prototype.SetterByBindingTypeAndVersioning=[[Me.prototype._setValue_direct,Me.prototype._setValue_direct_setNeedsUpdate,Me.prototype._setValue_direct_setMatrixWorldNeedsUpdate],[Me.prototype._setValue_array,Me.prototype._setValue_array_setNeedsUpdate,Me.prototype._setValue_array_setMatrixWorldNeedsUpdate],[Me.prototype._setValue_arrayElement,Me.prototype._setValue_arrayElement_setNeedsUpdate,Me.prototype._setValue_arrayElement_setMatrixWorldNeedsUpdate],[Me.prototype._setValue_fromArray,Me.prototype._setValue_fromArray_setNeedsUpdate,Me.prototype._setValue_fromArray_setMatrixWorldNeedsUpdate]];var Q8=new Float32Array(1);var Zp=class{static{this.prototype.isMatrix2=!0}constructor(t,n,i,r){this.elements=[1,0,0,1],t!==void 0&&this.set(t,n,i,r)}identity(){return this.set(1,0,0,1),this}fromArray(t,n=0){for(let i=0;i<4;i++)this.elements[i]=t[i+n];return this}set(t,n,i,r){let s=this.elements;return s[0]=t,s[2]=n,s[1]=i,s[3]=r,this}};function Rm(e,t,n,i){let r=EC(i);switch(n){case pm:return e*t;case gm:return e*t/r.components*r.byteLength;case _f:return e*t/r.components*r.byteLength;case xs:return e*t*2/r.components*r.byteLength;case vf:return e*t*2/r.components*r.byteLength;case mm:return e*t*3/r.components*r.byteLength;case Pi:return e*t*4/r.components*r.byteLength;case bf:return e*t*4/r.components*r.byteLength;case Gc:case Vc:return Math.floor((e+3)/4)*Math.floor((t+3)/4)*8;case Hc:case Wc:return Math.floor((e+3)/4)*Math.floor((t+3)/4)*16;case Sf:case Tf:return Math.max(e,16)*Math.max(t,8)/4;case Mf:case wf:return Math.max(e,8)*Math.max(t,8)/2;case Af:case Ef:case Rf:case If:return Math.floor((e+3)/4)*Math.floor((t+3)/4)*8;case Cf:case $c:case Pf:return Math.floor((e+3)/4)*Math.floor((t+3)/4)*16;case Lf:return Math.floor((e+3)/4)*Math.floor((t+3)/4)*16;case Nf:return Math.floor((e+4)/5)*Math.floor((t+3)/4)*16;case Df:return Math.floor((e+4)/5)*Math.floor((t+4)/5)*16;case Ff:return Math.floor((e+5)/6)*Math.floor((t+4)/5)*16;case Uf:return Math.floor((e+5)/6)*Math.floor((t+5)/6)*16;case Of:return Math.floor((e+7)/8)*Math.floor((t+4)/5)*16;case Bf:return Math.floor((e+7)/8)*Math.floor((t+5)/6)*16;case kf:return Math.floor((e+7)/8)*Math.floor((t+7)/8)*16;case zf:return Math.floor((e+9)/10)*Math.floor((t+4)/5)*16;case Gf:return Math.floor((e+9)/10)*Math.floor((t+5)/6)*16;case Vf:return Math.floor((e+9)/10)*Math.floor((t+7)/8)*16;case Hf:return Math.floor((e+9)/10)*Math.floor((t+9)/10)*16;case Wf:return Math.floor((e+11)/12)*Math.floor((t+9)/10)*16;case $f:return Math.floor((e+11)/12)*Math.floor((t+11)/12)*16;case Xf:case qf:case Yf:return Math.ceil(e/4)*Math.ceil(t/4)*16;case Zf:case Jf:return Math.ceil(e/4)*Math.ceil(t/4)*8;case Xc:case Kf:return Math.ceil(e/4)*Math.ceil(t/4)*16}throw new Error(`Unable to determine texture byte length for ${n} format.`)}function EC(e){switch(e){case On:case um:return{byteLength:1,components:1};case sa:case fm:case Ii:return{byteLength:2,components:1};case yf:case xf:return{byteLength:2,components:4};case Ci:case gf:case Ri:return{byteLength:4,components:1};case hm:case dm:return{byteLength:4,components:3}}throw new Error(`THREE.TextureUtils: Unknown texture type ${e}.`)}typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("register",{detail:{revision:"187"}}));typeof window<"u"&&(window.__THREE__?Ft("WARNING: Multiple instances of Three.js being imported."):window.__THREE__="187");function Nb(){let e=null,t=!1,n=null,i=null;function r(s,o){i=e.requestAnimationFrame(r),n(s,o)}return{start:function(){t!==!0&&n!==null&&e!==null&&(i=e.requestAnimationFrame(r),t=!0)},stop:function(){e!==null&&e.cancelAnimationFrame(i),t=!1},setAnimationLoop:function(s){n=s},setContext:function(s){e=s}}}function RC(e){let t=new WeakMap;function n(a,c){let l=a.array,u=a.usage,h=l.byteLength,f=e.createBuffer();e.bindBuffer(c,f),e.bufferData(c,l,u),a.onUploadCallback();let d;if(l instanceof Float32Array)d=e.FLOAT;else if(typeof Float16Array<"u"&&l instanceof Float16Array)d=e.HALF_FLOAT;else if(l instanceof Uint16Array)a.isFloat16BufferAttribute?d=e.HALF_FLOAT:d=e.UNSIGNED_SHORT;else if(l instanceof Int16Array)d=e.SHORT;else if(l instanceof Uint32Array)d=e.UNSIGNED_INT;else if(l instanceof Int32Array)d=e.INT;else if(l instanceof Int8Array)d=e.BYTE;else if(l instanceof Uint8Array)d=e.UNSIGNED_BYTE;else if(l instanceof Uint8ClampedArray)d=e.UNSIGNED_BYTE;else throw new Error("THREE.WebGLAttributes: Unsupported buffer data format: "+l);return{buffer:f,type:d,bytesPerElement:l.BYTES_PER_ELEMENT,version:a.version,size:h}}function i(a,c,l){let u=c.array,h=c.updateRanges;if(e.bindBuffer(l,a),h.length===0)e.bufferSubData(l,0,u);else{h.sort((d,p)=>d.start-p.start);let f=0;for(let d=1;d<h.length;d++){let p=h[f],y=h[d];y.start<=p.start+p.count+1?p.count=Math.max(p.count,y.start+y.count-p.start):(++f,h[f]=y)}h.length=f+1;for(let d=0,p=h.length;d<p;d++){let y=h[d];e.bufferSubData(l,y.start*u.BYTES_PER_ELEMENT,u,y.start,y.count)}c.clearUpdateRanges()}c.onUploadCallback()}function r(a){return a.isInterleavedBufferAttribute&&(a=a.data),t.get(a)}function s(a){a.isInterleavedBufferAttribute&&(a=a.data);let c=t.get(a);c&&(e.deleteBuffer(c.buffer),t.delete(a))}function o(a,c){if(a.isInterleavedBufferAttribute&&(a=a.data),a.isGLBufferAttribute){let u=t.get(a);(!u||u.version<a.version)&&t.set(a,{buffer:a.buffer,type:a.type,bytesPerElement:a.elementSize,version:a.version});return}let l=t.get(a);if(l===void 0)t.set(a,n(a,c));else if(l.version<a.version){if(l.size!==a.array.byteLength)throw new Error("THREE.WebGLAttributes: The size of the buffer attribute's array buffer does not match the original size. Resizing buffer attributes is not supported.");i(l.buffer,a,c),l.version=a.version}}return{get:r,remove:s,update:o}}var IC=`#ifdef USE_ALPHAHASH
	if ( diffuseColor.a < getAlphaHashThreshold( vPosition ) ) discard;
#endif`,PC=`#ifdef USE_ALPHAHASH
	const float ALPHA_HASH_SCALE = 0.05;
	float hash2D( vec2 value ) {
		return fract( 1.0e4 * sin( 17.0 * value.x + 0.1 * value.y ) * ( 0.1 + abs( sin( 13.0 * value.y + value.x ) ) ) );
	}
	float hash3D( vec3 value ) {
		return hash2D( vec2( hash2D( value.xy ), value.z ) );
	}
	float getAlphaHashThreshold( vec3 position ) {
		float maxDeriv = max(
			length( dFdx( position.xyz ) ),
			length( dFdy( position.xyz ) )
		);
		float pixScale = 1.0 / ( ALPHA_HASH_SCALE * maxDeriv );
		vec2 pixScales = vec2(
			exp2( floor( log2( pixScale ) ) ),
			exp2( ceil( log2( pixScale ) ) )
		);
		vec2 alpha = vec2(
			hash3D( floor( pixScales.x * position.xyz ) ),
			hash3D( floor( pixScales.y * position.xyz ) )
		);
		float lerpFactor = fract( log2( pixScale ) );
		float x = ( 1.0 - lerpFactor ) * alpha.x + lerpFactor * alpha.y;
		float a = min( lerpFactor, 1.0 - lerpFactor );
		vec3 cases = vec3(
			x * x / ( 2.0 * a * ( 1.0 - a ) ),
			( x - 0.5 * a ) / ( 1.0 - a ),
			1.0 - ( ( 1.0 - x ) * ( 1.0 - x ) / ( 2.0 * a * ( 1.0 - a ) ) )
		);
		float threshold = ( x < ( 1.0 - a ) )
			? ( ( x < a ) ? cases.x : cases.y )
			: cases.z;
		return clamp( threshold , 1.0e-6, 1.0 );
	}
#endif`,LC=`#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, vAlphaMapUv ).g;
#endif`,NC=`#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,DC=`#ifdef USE_ALPHATEST
	#ifdef ALPHA_TO_COVERAGE
	diffuseColor.a = smoothstep( alphaTest, alphaTest + fwidth( diffuseColor.a ), diffuseColor.a );
	if ( diffuseColor.a == 0.0 ) discard;
	#else
	if ( diffuseColor.a < alphaTest ) discard;
	#endif
#endif`,FC=`#ifdef USE_ALPHATEST
	uniform float alphaTest;
#endif`,UC=`#ifdef USE_AOMAP
	float ambientOcclusion = ( texture2D( aoMap, vAoMapUv ).r - 1.0 ) * aoMapIntensity + 1.0;
	reflectedLight.indirectDiffuse *= ambientOcclusion;
	#if defined( USE_CLEARCOAT ) 
		clearcoatSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_SHEEN ) 
		sheenSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_ENVMAP ) && defined( STANDARD )
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		reflectedLight.indirectSpecular *= computeSpecularOcclusion( dotNV, ambientOcclusion, material.roughness );
	#endif
#endif`,OC=`#ifdef USE_AOMAP
	uniform sampler2D aoMap;
	uniform float aoMapIntensity;
#endif`,BC=`#ifdef USE_BATCHING
	#if ! defined( GL_ANGLE_multi_draw )
	#define gl_DrawID _gl_DrawID
	uniform int _gl_DrawID;
	#endif
	uniform highp sampler2D batchingTexture;
	uniform highp usampler2D batchingIdTexture;
	mat4 getBatchingMatrix( const in float i ) {
		int size = textureSize( batchingTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( batchingTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( batchingTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( batchingTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( batchingTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
	float getIndirectIndex( const in int i ) {
		int size = textureSize( batchingIdTexture, 0 ).x;
		int x = i % size;
		int y = i / size;
		return float( texelFetch( batchingIdTexture, ivec2( x, y ), 0 ).r );
	}
#endif
#ifdef USE_BATCHING_COLOR
	uniform sampler2D batchingColorTexture;
	vec4 getBatchingColor( const in float i ) {
		int size = textureSize( batchingColorTexture, 0 ).x;
		int j = int( i );
		int x = j % size;
		int y = j / size;
		return texelFetch( batchingColorTexture, ivec2( x, y ), 0 );
	}
#endif`,kC=`#ifdef USE_BATCHING
	mat4 batchingMatrix = getBatchingMatrix( getIndirectIndex( gl_DrawID ) );
#endif`,zC=`vec3 transformed = vec3( position );
#ifdef USE_ALPHAHASH
	vPosition = vec3( position );
#endif`,GC=`vec3 objectNormal = vec3( normal );
#ifdef USE_TANGENT
	vec3 objectTangent = vec3( tangent.xyz );
#endif`,VC=`float G_BlinnPhong_Implicit( ) {
	return 0.25;
}
float D_BlinnPhong( const in float shininess, const in float dotNH ) {
	return RECIPROCAL_PI * ( shininess * 0.5 + 1.0 ) * pow( dotNH, shininess );
}
vec3 BRDF_BlinnPhong( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 specularColor, const in float shininess ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( specularColor, 1.0, dotVH );
	float G = G_BlinnPhong_Implicit( );
	float D = D_BlinnPhong( shininess, dotNH );
	return F * ( G * D );
} // validated`,HC=`#ifdef USE_IRIDESCENCE
	const mat3 XYZ_TO_REC709 = mat3(
		 3.2404542, -0.9692660,  0.0556434,
		-1.5371385,  1.8760108, -0.2040259,
		-0.4985314,  0.0415560,  1.0572252
	);
	vec3 Fresnel0ToIor( vec3 fresnel0 ) {
		vec3 sqrtF0 = sqrt( fresnel0 );
		return ( vec3( 1.0 ) + sqrtF0 ) / ( vec3( 1.0 ) - sqrtF0 );
	}
	vec3 IorToFresnel0( vec3 transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - vec3( incidentIor ) ) / ( transmittedIor + vec3( incidentIor ) ) );
	}
	float IorToFresnel0( float transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - incidentIor ) / ( transmittedIor + incidentIor ));
	}
	vec3 evalSensitivity( float OPD, vec3 shift ) {
		float phase = 2.0 * PI * OPD * 1.0e-9;
		vec3 val = vec3( 5.4856e-13, 4.4201e-13, 5.2481e-13 );
		vec3 pos = vec3( 1.6810e+06, 1.7953e+06, 2.2084e+06 );
		vec3 var = vec3( 4.3278e+09, 9.3046e+09, 6.6121e+09 );
		vec3 xyz = val * sqrt( 2.0 * PI * var ) * cos( pos * phase + shift ) * exp( - pow2( phase ) * var );
		xyz.x += 9.7470e-14 * sqrt( 2.0 * PI * 4.5282e+09 ) * cos( 2.2399e+06 * phase + shift[ 0 ] ) * exp( - 4.5282e+09 * pow2( phase ) );
		xyz /= 1.0685e-7;
		vec3 rgb = XYZ_TO_REC709 * xyz;
		return rgb;
	}
	vec3 evalIridescence( float outsideIOR, float eta2, float cosTheta1, float thinFilmThickness, vec3 baseF0 ) {
		vec3 I;
		float iridescenceIOR = mix( outsideIOR, eta2, smoothstep( 0.0, 0.03, thinFilmThickness ) );
		float sinTheta2Sq = pow2( outsideIOR / iridescenceIOR ) * ( 1.0 - pow2( cosTheta1 ) );
		float cosTheta2Sq = 1.0 - sinTheta2Sq;
		if ( cosTheta2Sq < 0.0 ) {
			return vec3( 1.0 );
		}
		float cosTheta2 = sqrt( cosTheta2Sq );
		float R0 = IorToFresnel0( iridescenceIOR, outsideIOR );
		float R12 = F_Schlick( R0, 1.0, cosTheta1 );
		float T121 = 1.0 - R12;
		float phi12 = 0.0;
		if ( iridescenceIOR < outsideIOR ) phi12 = PI;
		float phi21 = PI - phi12;
		vec3 baseIOR = Fresnel0ToIor( clamp( baseF0, 0.0, 0.9999 ) );		vec3 R1 = IorToFresnel0( baseIOR, iridescenceIOR );
		vec3 R23 = F_Schlick( R1, 1.0, cosTheta2 );
		vec3 phi23 = vec3( 0.0 );
		if ( baseIOR[ 0 ] < iridescenceIOR ) phi23[ 0 ] = PI;
		if ( baseIOR[ 1 ] < iridescenceIOR ) phi23[ 1 ] = PI;
		if ( baseIOR[ 2 ] < iridescenceIOR ) phi23[ 2 ] = PI;
		float OPD = 2.0 * iridescenceIOR * thinFilmThickness * cosTheta2;
		vec3 phi = vec3( phi21 ) + phi23;
		vec3 R123 = clamp( R12 * R23, 1e-5, 0.9999 );
		vec3 r123 = sqrt( R123 );
		vec3 Rs = pow2( T121 ) * R23 / ( vec3( 1.0 ) - R123 );
		vec3 C0 = R12 + Rs;
		I = C0;
		vec3 Cm = Rs - T121;
		for ( int m = 1; m <= 2; ++ m ) {
			Cm *= r123;
			vec3 Sm = 2.0 * evalSensitivity( float( m ) * OPD, float( m ) * phi );
			I += Cm * Sm;
		}
		return max( I, vec3( 0.0 ) );
	}
#endif`,WC=`#ifdef USE_BUMPMAP
	uniform sampler2D bumpMap;
	uniform float bumpScale;
	vec2 dHdxy_fwd() {
		vec2 dSTdx = dFdx( vBumpMapUv );
		vec2 dSTdy = dFdy( vBumpMapUv );
		float Hll = bumpScale * texture2D( bumpMap, vBumpMapUv ).x;
		float dBx = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdx ).x - Hll;
		float dBy = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdy ).x - Hll;
		return vec2( dBx, dBy );
	}
	vec3 perturbNormalArb( vec3 surf_pos, vec3 surf_norm, vec2 dHdxy, float faceDirection ) {
		vec3 vSigmaX = normalize( dFdx( surf_pos.xyz ) );
		vec3 vSigmaY = normalize( dFdy( surf_pos.xyz ) );
		vec3 vN = surf_norm;
		vec3 R1 = cross( vSigmaY, vN );
		vec3 R2 = cross( vN, vSigmaX );
		float fDet = dot( vSigmaX, R1 ) * faceDirection;
		vec3 vGrad = sign( fDet ) * ( dHdxy.x * R1 + dHdxy.y * R2 );
		return normalize( abs( fDet ) * surf_norm - vGrad );
	}
#endif`,$C=`#if NUM_CLIPPING_PLANES > 0
	vec4 plane;
	#ifdef ALPHA_TO_COVERAGE
		float distanceToPlane, distanceGradient;
		float clipOpacity = 1.0;
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
			distanceGradient = fwidth( distanceToPlane ) / 2.0;
			clipOpacity *= smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			if ( clipOpacity == 0.0 ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			float unionClipOpacity = 1.0;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
				distanceGradient = fwidth( distanceToPlane ) / 2.0;
				unionClipOpacity *= 1.0 - smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			}
			#pragma unroll_loop_end
			clipOpacity *= 1.0 - unionClipOpacity;
		#endif
		diffuseColor.a *= clipOpacity;
		if ( diffuseColor.a == 0.0 ) discard;
	#else
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			if ( dot( vClipPosition, plane.xyz ) > plane.w ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			bool clipped = true;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				clipped = ( dot( vClipPosition, plane.xyz ) > plane.w ) && clipped;
			}
			#pragma unroll_loop_end
			if ( clipped ) discard;
		#endif
	#endif
#endif`,XC=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
	uniform vec4 clippingPlanes[ NUM_CLIPPING_PLANES ];
#endif`,qC=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
#endif`,YC=`#if NUM_CLIPPING_PLANES > 0
	vClipPosition = - mvPosition.xyz;
#endif`,ZC=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	diffuseColor *= vColor;
#endif`,JC=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	varying vec4 vColor;
#endif`,KC=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	varying vec4 vColor;
#endif`,jC=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	vColor = vec4( 1.0 );
#endif
#ifdef USE_COLOR_ALPHA
	vColor *= color;
#elif defined( USE_COLOR )
	vColor.rgb *= color;
#endif
#ifdef USE_INSTANCING_COLOR
	vColor.rgb *= instanceColor.rgb;
#endif
#ifdef USE_BATCHING_COLOR
	vColor *= getBatchingColor( getIndirectIndex( gl_DrawID ) );
#endif`,QC=`#define PI 3.141592653589793
#define PI2 6.283185307179586
#define PI_HALF 1.5707963267948966
#define RECIPROCAL_PI 0.3183098861837907
#define RECIPROCAL_PI2 0.15915494309189535
#define EPSILON 1e-6
#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
#define whiteComplement( a ) ( 1.0 - saturate( a ) )
float pow2( const in float x ) { return x*x; }
vec3 pow2( const in vec3 x ) { return x*x; }
float pow3( const in float x ) { return x*x*x; }
float pow4( const in float x ) { float x2 = x*x; return x2*x2; }
float max3( const in vec3 v ) { return max( max( v.x, v.y ), v.z ); }
float average( const in vec3 v ) { return dot( v, vec3( 0.3333333 ) ); }
highp float rand( const in vec2 uv ) {
	const highp float a = 12.9898, b = 78.233, c = 43758.5453;
	highp float dt = dot( uv.xy, vec2( a,b ) ), sn = mod( dt, PI );
	return fract( sin( sn ) * c );
}
#ifdef HIGH_PRECISION
	float precisionSafeLength( vec3 v ) { return length( v ); }
#else
	float precisionSafeLength( vec3 v ) {
		float maxComponent = max3( abs( v ) );
		return length( v / maxComponent ) * maxComponent;
	}
#endif
struct IncidentLight {
	vec3 color;
	vec3 direction;
	bool visible;
};
struct ReflectedLight {
	vec3 directDiffuse;
	vec3 directSpecular;
	vec3 indirectDiffuse;
	vec3 indirectSpecular;
};
#ifdef USE_ALPHAHASH
	varying vec3 vPosition;
#endif
vec3 transformDirection( in vec3 dir, in mat4 matrix ) {
	return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );
}
#define inverseTransformDirection transformDirectionByInverseViewMatrix
vec3 transformNormalByInverseViewMatrix( in vec3 normal, in mat4 viewMatrix ) {
	return normalize( ( vec4( normal, 0.0 ) * viewMatrix ).xyz );
}
vec3 transformDirectionByInverseViewMatrix( in vec3 dir, in mat4 viewMatrix ) {
	return normalize( ( vec4( dir, 0.0 ) * viewMatrix ).xyz );
}
bool isPerspectiveMatrix( mat4 m ) {
	return m[ 2 ][ 3 ] == - 1.0;
}
vec2 equirectUv( in vec3 dir ) {
	float u = atan( dir.z, dir.x ) * RECIPROCAL_PI2 + 0.5;
	float v = asin( clamp( dir.y, - 1.0, 1.0 ) ) * RECIPROCAL_PI + 0.5;
	return vec2( u, v );
}
vec3 BRDF_Lambert( const in vec3 diffuseColor ) {
	return RECIPROCAL_PI * diffuseColor;
}
vec3 F_Schlick( const in vec3 f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
}
float F_Schlick( const in float f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
} // validated`,tR=`vec3 transformedNormal = objectNormal;
#ifdef USE_TANGENT
	vec3 transformedTangent = objectTangent;
#endif
#ifdef USE_BATCHING
	mat3 bm = mat3( batchingMatrix );
	transformedNormal /= vec3( dot( bm[ 0 ], bm[ 0 ] ), dot( bm[ 1 ], bm[ 1 ] ), dot( bm[ 2 ], bm[ 2 ] ) );
	transformedNormal = bm * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = bm * transformedTangent;
	#endif
#endif
#ifdef USE_INSTANCING
	mat3 im = mat3( instanceMatrix );
	transformedNormal /= vec3( dot( im[ 0 ], im[ 0 ] ), dot( im[ 1 ], im[ 1 ] ), dot( im[ 2 ], im[ 2 ] ) );
	transformedNormal = im * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = im * transformedTangent;
	#endif
#endif
transformedNormal = normalMatrix * transformedNormal;
#ifdef FLIP_SIDED
	transformedNormal = - transformedNormal;
#endif
#ifdef USE_TANGENT
	transformedTangent = ( modelViewMatrix * vec4( transformedTangent, 0.0 ) ).xyz;
#endif`,eR=`#ifdef USE_DISPLACEMENTMAP
	uniform sampler2D displacementMap;
	uniform float displacementScale;
	uniform float displacementBias;
#endif`,nR=`#ifdef USE_DISPLACEMENTMAP
	transformed += normalize( objectNormal ) * ( texture2D( displacementMap, vDisplacementMapUv ).x * displacementScale + displacementBias );
#endif`,iR=`#ifdef USE_EMISSIVEMAP
	vec4 emissiveColor = texture2D( emissiveMap, vEmissiveMapUv );
	#ifdef DECODE_VIDEO_TEXTURE_EMISSIVE
		emissiveColor = sRGBTransferEOTF( emissiveColor );
	#endif
	totalEmissiveRadiance *= emissiveColor.rgb;
#endif`,rR=`#ifdef USE_EMISSIVEMAP
	uniform sampler2D emissiveMap;
#endif`,sR="gl_FragColor = linearToOutputTexel( gl_FragColor );",oR=`vec4 LinearTransferOETF( in vec4 value ) {
	return value;
}
vec4 sRGBTransferEOTF( in vec4 value ) {
	return vec4( mix( pow( value.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), value.rgb * 0.0773993808, vec3( lessThanEqual( value.rgb, vec3( 0.04045 ) ) ) ), value.a );
}
vec4 sRGBTransferOETF( in vec4 value ) {
	return vec4( mix( pow( value.rgb, vec3( 0.41666 ) ) * 1.055 - vec3( 0.055 ), value.rgb * 12.92, vec3( lessThanEqual( value.rgb, vec3( 0.0031308 ) ) ) ), value.a );
}`,aR=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vec3 cameraToFrag;
		if ( isOrthographic ) {
			cameraToFrag = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToFrag = normalize( vWorldPosition - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vec3 reflectVec = reflect( cameraToFrag, worldNormal );
		#else
			vec3 reflectVec = refract( cameraToFrag, worldNormal, refractionRatio );
		#endif
	#else
		vec3 reflectVec = vReflect;
	#endif
	#ifdef ENVMAP_TYPE_CUBE
		vec4 envColor = textureCube( envMap, envMapRotation * reflectVec );
		#ifdef ENVMAP_BLENDING_MULTIPLY
			outgoingLight = mix( outgoingLight, outgoingLight * envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_MIX )
			outgoingLight = mix( outgoingLight, envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_ADD )
			outgoingLight += envColor.xyz * specularStrength * reflectivity;
		#endif
	#endif
#endif`,cR=`#ifdef USE_ENVMAP
	uniform float envMapIntensity;
	uniform mat3 envMapRotation;
	uniform samplerCube envMap;
	#ifdef ENVMAP_TYPE_PMREM
		float roughnessToMip( const in float roughness ) {
			float r = clamp( roughness, 0.0, 1.0 );
			return ENVMAP_MAX_LOD * r * ( 2.0 - r );
		}
	#endif
#endif`,lR=`#ifdef USE_ENVMAP
	uniform float reflectivity;
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		varying vec3 vWorldPosition;
		uniform float refractionRatio;
	#else
		varying vec3 vReflect;
	#endif
#endif`,uR=`#ifdef USE_ENVMAP
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		
		varying vec3 vWorldPosition;
	#else
		varying vec3 vReflect;
		uniform float refractionRatio;
	#endif
#endif`,fR=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vWorldPosition = worldPosition.xyz;
	#else
		vec3 cameraToVertex;
		if ( isOrthographic ) {
			cameraToVertex = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToVertex = normalize( worldPosition.xyz - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vReflect = reflect( cameraToVertex, worldNormal );
		#else
			vReflect = refract( cameraToVertex, worldNormal, refractionRatio );
		#endif
	#endif
#endif`,hR=`#ifdef USE_FOG
	vFogDepth = - mvPosition.z;
#endif`,dR=`#ifdef USE_FOG
	varying float vFogDepth;
#endif`,pR=`#ifdef USE_FOG
	#ifdef FOG_EXP2
		float fogFactor = 1.0 - exp( - fogDensity * fogDensity * vFogDepth * vFogDepth );
	#else
		float fogFactor = smoothstep( fogNear, fogFar, vFogDepth );
	#endif
	gl_FragColor.rgb = mix( gl_FragColor.rgb, fogColor, fogFactor );
#endif`,mR=`#ifdef USE_FOG
	uniform vec3 fogColor;
	varying float vFogDepth;
	#ifdef FOG_EXP2
		uniform float fogDensity;
	#else
		uniform float fogNear;
		uniform float fogFar;
	#endif
#endif`,gR=`#ifdef USE_GRADIENTMAP
	uniform sampler2D gradientMap;
#endif
vec3 getGradientIrradiance( vec3 normal, vec3 lightDirection ) {
	float dotNL = dot( normal, lightDirection );
	vec2 coord = vec2( dotNL * 0.5 + 0.5, 0.0 );
	#ifdef USE_GRADIENTMAP
		return vec3( texture2D( gradientMap, coord ).r );
	#else
		vec2 fw = fwidth( coord ) * 0.5;
		return mix( vec3( 0.7 ), vec3( 1.0 ), smoothstep( 0.7 - fw.x, 0.7 + fw.x, coord.x ) );
	#endif
}`,yR=`#ifdef USE_LIGHTMAP
	uniform sampler2D lightMap;
	uniform float lightMapIntensity;
#endif`,xR=`LambertMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularStrength = specularStrength;`,_R=`varying vec3 vViewPosition;
struct LambertMaterial {
	vec3 diffuseColor;
	float specularStrength;
};
void RE_Direct_Lambert( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Lambert( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Lambert
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Lambert`,vR=`uniform bool receiveShadow;
uniform vec3 ambientLightColor;
#if defined( USE_LIGHT_PROBES )
	uniform vec3 lightProbe[ 9 ];
#endif
vec3 shGetIrradianceAt( in vec3 normal, in vec3 shCoefficients[ 9 ] ) {
	float x = normal.x, y = normal.y, z = normal.z;
	vec3 result = shCoefficients[ 0 ] * 0.886227;
	result += shCoefficients[ 1 ] * 2.0 * 0.511664 * y;
	result += shCoefficients[ 2 ] * 2.0 * 0.511664 * z;
	result += shCoefficients[ 3 ] * 2.0 * 0.511664 * x;
	result += shCoefficients[ 4 ] * 2.0 * 0.429043 * x * y;
	result += shCoefficients[ 5 ] * 2.0 * 0.429043 * y * z;
	result += shCoefficients[ 6 ] * ( 0.743125 * z * z - 0.247708 );
	result += shCoefficients[ 7 ] * 2.0 * 0.429043 * x * z;
	result += shCoefficients[ 8 ] * 0.429043 * ( x * x - y * y );
	return result;
}
vec3 getLightProbeIrradiance( const in vec3 lightProbe[ 9 ], const in vec3 normal ) {
	vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec3 irradiance = shGetIrradianceAt( worldNormal, lightProbe );
	return irradiance;
}
vec3 getAmbientLightIrradiance( const in vec3 ambientLightColor ) {
	vec3 irradiance = ambientLightColor;
	return irradiance;
}
float getDistanceAttenuation( const in float lightDistance, const in float cutoffDistance, const in float decayExponent ) {
	float distanceFalloff = 1.0 / max( pow( lightDistance, decayExponent ), 0.01 );
	if ( cutoffDistance > 0.0 ) {
		distanceFalloff *= pow2( saturate( 1.0 - pow4( lightDistance / cutoffDistance ) ) );
	}
	return distanceFalloff;
}
float getSpotAttenuation( const in float coneCosine, const in float penumbraCosine, const in float angleCosine ) {
	return smoothstep( coneCosine, penumbraCosine, angleCosine );
}
#if NUM_SUN_LIGHTS > 0
	struct SunLight {
		vec3 direction;
		vec3 color;
	};
	uniform SunLight sunLights[ NUM_SUN_LIGHTS ];
	void getSunLightInfo( const in SunLight sunLight, out IncidentLight light ) {
		light.color = sunLight.color;
		light.direction = sunLight.direction;
		light.visible = true;
	}
#endif
#if NUM_DIR_LIGHTS > 0
	struct DirectionalLight {
		vec3 direction;
		vec3 color;
	};
	uniform DirectionalLight directionalLights[ NUM_DIR_LIGHTS ];
	void getDirectionalLightInfo( const in DirectionalLight directionalLight, out IncidentLight light ) {
		light.color = directionalLight.color;
		light.direction = directionalLight.direction;
		light.visible = true;
	}
#endif
#if NUM_POINT_LIGHTS > 0
	struct PointLight {
		vec3 position;
		vec3 color;
		float distance;
		float decay;
	};
	uniform PointLight pointLights[ NUM_POINT_LIGHTS ];
	void getPointLightInfo( const in PointLight pointLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = pointLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float lightDistance = length( lVector );
		light.color = pointLight.color;
		light.color *= getDistanceAttenuation( lightDistance, pointLight.distance, pointLight.decay );
		light.visible = ( light.color != vec3( 0.0 ) );
	}
#endif
#if NUM_SPOT_LIGHTS > 0
	struct SpotLight {
		vec3 position;
		vec3 direction;
		vec3 color;
		float distance;
		float decay;
		float coneCos;
		float penumbraCos;
	};
	uniform SpotLight spotLights[ NUM_SPOT_LIGHTS ];
	void getSpotLightInfo( const in SpotLight spotLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = spotLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float angleCos = dot( light.direction, spotLight.direction );
		float spotAttenuation = getSpotAttenuation( spotLight.coneCos, spotLight.penumbraCos, angleCos );
		if ( spotAttenuation > 0.0 ) {
			float lightDistance = length( lVector );
			light.color = spotLight.color * spotAttenuation;
			light.color *= getDistanceAttenuation( lightDistance, spotLight.distance, spotLight.decay );
			light.visible = ( light.color != vec3( 0.0 ) );
		} else {
			light.color = vec3( 0.0 );
			light.visible = false;
		}
	}
#endif
#if NUM_RECT_AREA_LIGHTS > 0
	struct RectAreaLight {
		vec3 color;
		vec3 position;
		vec3 halfWidth;
		vec3 halfHeight;
	};
	uniform sampler2D ltc_1;	uniform sampler2D ltc_2;
	uniform RectAreaLight rectAreaLights[ NUM_RECT_AREA_LIGHTS ];
#endif
#if NUM_HEMI_LIGHTS > 0
	struct HemisphereLight {
		vec3 direction;
		vec3 skyColor;
		vec3 groundColor;
	};
	uniform HemisphereLight hemisphereLights[ NUM_HEMI_LIGHTS ];
	vec3 getHemisphereLightIrradiance( const in HemisphereLight hemiLight, const in vec3 normal ) {
		float dotNL = dot( normal, hemiLight.direction );
		float hemiDiffuseWeight = 0.5 * dotNL + 0.5;
		vec3 irradiance = mix( hemiLight.groundColor, hemiLight.skyColor, hemiDiffuseWeight );
		return irradiance;
	}
#endif
#include <lightprobes_pars_fragment>`,bR=`#ifdef USE_ENVMAP
	vec3 getIBLIrradiance( const in vec3 normal ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * worldNormal, ENVMAP_MAX_LOD );
			return PI * envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	vec3 getIBLRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 reflectVec = reflect( - viewDir, normal );
			reflectVec = normalize( mix( reflectVec, normal, pow4( roughness ) ) );
			reflectVec = transformDirectionByInverseViewMatrix( reflectVec, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * reflectVec, roughnessToMip( roughness ) );
			return envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	#ifdef USE_RETROREFLECTION
		vec3 getIBLRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 retroVec = normalize( mix( viewDir, normal, pow4( roughness ) ) );
				retroVec = transformDirectionByInverseViewMatrix( retroVec, viewMatrix );
				vec4 envMapColor = textureLod( envMap, envMapRotation * retroVec, roughnessToMip( roughness ) );
				return envMapColor.rgb * envMapIntensity;
			#else
				return vec3( 0.0 );
			#endif
		}
	#endif
	#ifdef USE_ANISOTROPY
		vec3 getIBLAnisotropyRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 bentNormal = cross( bitangent, viewDir );
				bentNormal = normalize( cross( bentNormal, bitangent ) );
				bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
				return getIBLRadiance( viewDir, bentNormal, roughness );
			#else
				return vec3( 0.0 );
			#endif
		}
		#ifdef USE_RETROREFLECTION
			vec3 getIBLAnisotropyRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
				#ifdef ENVMAP_TYPE_PMREM
					vec3 bentNormal = cross( bitangent, viewDir );
					bentNormal = normalize( cross( bentNormal, bitangent ) );
					bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
					return getIBLRetroRadiance( viewDir, bentNormal, roughness );
				#else
					return vec3( 0.0 );
				#endif
			}
		#endif
	#endif
#endif`,MR=`ToonMaterial material;
material.diffuseColor = diffuseColor.rgb;`,SR=`varying vec3 vViewPosition;
struct ToonMaterial {
	vec3 diffuseColor;
};
void RE_Direct_Toon( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 irradiance = getGradientIrradiance( geometryNormal, directLight.direction ) * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Toon( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Toon
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Toon`,wR=`BlinnPhongMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularColor = specular;
material.specularShininess = shininess;
material.specularStrength = specularStrength;`,TR=`varying vec3 vViewPosition;
struct BlinnPhongMaterial {
	vec3 diffuseColor;
	vec3 specularColor;
	float specularShininess;
	float specularStrength;
};
void RE_Direct_BlinnPhong( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
	reflectedLight.directSpecular += irradiance * BRDF_BlinnPhong( directLight.direction, geometryViewDir, geometryNormal, material.specularColor, material.specularShininess ) * material.specularStrength;
}
void RE_IndirectDiffuse_BlinnPhong( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_BlinnPhong
#define RE_IndirectDiffuse		RE_IndirectDiffuse_BlinnPhong`,AR=`PhysicalMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.diffuseContribution = diffuseColor.rgb * ( 1.0 - metalnessFactor );
material.metalness = metalnessFactor;
vec3 dxy = max( abs( dFdx( nonPerturbedNormal ) ), abs( dFdy( nonPerturbedNormal ) ) );
float geometryRoughness = max( max( dxy.x, dxy.y ), dxy.z );
material.roughness = max( roughnessFactor, 0.045 );
material.roughness += geometryRoughness;
material.roughness = min( material.roughness, 1.0 );
#ifdef USE_DIFFUSE_ROUGHNESS
	float diffuseRoughnessFactor = diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		diffuseRoughnessFactor *= texture2D( diffuseRoughnessMap, vDiffuseRoughnessMapUv ).r;
	#endif
	material.diffuseRoughness = saturate( diffuseRoughnessFactor );
#endif
#ifdef IOR
	material.ior = ior;
	#ifdef USE_SPECULAR
		float specularIntensityFactor = specularIntensity;
		vec3 specularColorFactor = specularColor;
		#ifdef USE_SPECULAR_COLORMAP
			specularColorFactor *= texture2D( specularColorMap, vSpecularColorMapUv ).rgb;
		#endif
		#ifdef USE_SPECULAR_INTENSITYMAP
			specularIntensityFactor *= texture2D( specularIntensityMap, vSpecularIntensityMapUv ).a;
		#endif
		material.specularF90 = mix( specularIntensityFactor, 1.0, metalnessFactor );
	#else
		float specularIntensityFactor = 1.0;
		vec3 specularColorFactor = vec3( 1.0 );
		material.specularF90 = 1.0;
	#endif
	material.specularColor = min( pow2( ( material.ior - 1.0 ) / ( material.ior + 1.0 ) ) * specularColorFactor, vec3( 1.0 ) ) * specularIntensityFactor;
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
#else
	material.specularColor = vec3( 0.04 );
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
	material.specularF90 = 1.0;
#endif
#ifdef USE_CLEARCOAT
	material.clearcoat = clearcoat;
	material.clearcoatRoughness = clearcoatRoughness;
	material.clearcoatF0 = vec3( 0.04 );
	material.clearcoatF90 = 1.0;
	#ifdef USE_CLEARCOATMAP
		material.clearcoat *= texture2D( clearcoatMap, vClearcoatMapUv ).x;
	#endif
	#ifdef USE_CLEARCOAT_ROUGHNESSMAP
		material.clearcoatRoughness *= texture2D( clearcoatRoughnessMap, vClearcoatRoughnessMapUv ).y;
	#endif
	material.clearcoat = saturate( material.clearcoat );	material.clearcoatRoughness = max( material.clearcoatRoughness, 0.045 );
	material.clearcoatRoughness += geometryRoughness;
	material.clearcoatRoughness = min( material.clearcoatRoughness, 1.0 );
#endif
#ifdef USE_DISPERSION
	material.dispersion = dispersion;
#endif
#ifdef USE_RETROREFLECTION
	material.retroreflectivity = retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	material.iridescence = iridescence;
	material.iridescenceIOR = iridescenceIOR;
	#ifdef USE_IRIDESCENCEMAP
		material.iridescence *= texture2D( iridescenceMap, vIridescenceMapUv ).r;
	#endif
	#ifdef USE_IRIDESCENCE_THICKNESSMAP
		material.iridescenceThickness = (iridescenceThicknessMaximum - iridescenceThicknessMinimum) * texture2D( iridescenceThicknessMap, vIridescenceThicknessMapUv ).g + iridescenceThicknessMinimum;
	#else
		material.iridescenceThickness = iridescenceThicknessMaximum;
	#endif
#endif
#ifdef USE_SHEEN
	material.sheenColor = sheenColor;
	#ifdef USE_SHEEN_COLORMAP
		material.sheenColor *= texture2D( sheenColorMap, vSheenColorMapUv ).rgb;
	#endif
	material.sheenRoughness = clamp( sheenRoughness, 0.0001, 1.0 );
	#ifdef USE_SHEEN_ROUGHNESSMAP
		material.sheenRoughness *= texture2D( sheenRoughnessMap, vSheenRoughnessMapUv ).a;
	#endif
#endif
#ifdef USE_ANISOTROPY
	#ifdef USE_ANISOTROPYMAP
		mat2 anisotropyMat = mat2( anisotropyVector.x, anisotropyVector.y, - anisotropyVector.y, anisotropyVector.x );
		vec3 anisotropyPolar = texture2D( anisotropyMap, vAnisotropyMapUv ).rgb;
		vec2 anisotropyV = anisotropyMat * normalize( 2.0 * anisotropyPolar.rg - vec2( 1.0 ) ) * anisotropyPolar.b;
	#else
		vec2 anisotropyV = anisotropyVector;
	#endif
	material.anisotropy = length( anisotropyV );
	if( material.anisotropy == 0.0 ) {
		anisotropyV = vec2( 1.0, 0.0 );
	} else {
		anisotropyV /= material.anisotropy;
		material.anisotropy = saturate( material.anisotropy );
	}
	material.alphaT = mix( pow2( material.roughness ), 1.0, pow2( material.anisotropy ) );
	material.anisotropyT = tbn[ 0 ] * anisotropyV.x + tbn[ 1 ] * anisotropyV.y;
	material.anisotropyB = tbn[ 1 ] * anisotropyV.x - tbn[ 0 ] * anisotropyV.y;
#endif`,ER=`uniform sampler2D dfgLUT;
struct PhysicalMaterial {
	vec3 diffuseColor;
	vec3 diffuseContribution;
	vec3 specularColor;
	vec3 specularColorBlended;
	float roughness;
	float metalness;
	float specularF90;
	float dispersion;
	vec2 dfg;
	vec3 multiScatteringCompensation;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float diffuseRoughness;
	#endif
	#ifdef USE_RETROREFLECTION
		float retroreflectivity;
	#endif
	#ifdef USE_CLEARCOAT
		float clearcoat;
		float clearcoatRoughness;
		vec3 clearcoatF0;
		float clearcoatF90;
	#endif
	#ifdef USE_IRIDESCENCE
		float iridescence;
		float iridescenceIOR;
		float iridescenceThickness;
		vec3 iridescenceFresnel;
		vec3 iridescenceF0Dielectric;
		vec3 iridescenceF0Metallic;
	#endif
	#ifdef USE_SHEEN
		vec3 sheenColor;
		float sheenRoughness;
	#endif
	#ifdef IOR
		float ior;
	#endif
	#ifdef USE_TRANSMISSION
		float transmission;
		float transmissionAlpha;
		float thickness;
		float attenuationDistance;
		vec3 attenuationColor;
	#endif
	#ifdef USE_ANISOTROPY
		float anisotropy;
		float alphaT;
		vec3 anisotropyT;
		vec3 anisotropyB;
	#endif
};
vec3 clearcoatSpecularDirect = vec3( 0.0 );
vec3 clearcoatSpecularIndirect = vec3( 0.0 );
vec3 sheenSpecularDirect = vec3( 0.0 );
vec3 sheenSpecularIndirect = vec3(0.0 );
vec3 Schlick_to_F0( const in vec3 f, const in float f90, const in float dotVH ) {
    float x = clamp( 1.0 - dotVH, 0.0, 1.0 );
    float x2 = x * x;
    float x5 = clamp( x * x2 * x2, 0.0, 0.9999 );
    return ( f - vec3( f90 ) * x5 ) / ( 1.0 - x5 );
}
#ifdef USE_DIFFUSE_ROUGHNESS
	const float EON_EPSILON = 1e-7;
	float FON_DirectionalAlbedo( const in float mu, const in float roughness, const in float A ) {
		float muComp = 1.0 - mu;
		float gOverPi = muComp * ( 0.0571085289 + muComp * ( 0.491881867 + muComp * ( - 0.332181442 + muComp * 0.0714429953 ) ) );
		return A * ( 1.0 + roughness * gOverPi );
	}
	vec3 BRDF_EON( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 diffuseColor, const in float roughness ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return BRDF_Lambert( rho );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float s = dot( lightDir, viewDir ) - dotNL * dotNV;
		float sOverT = ( s > 0.0 ) ? s / max( max( dotNL, dotNV ), EON_EPSILON ) : s;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		vec3 singleScatter = rho * RECIPROCAL_PI * A * ( 1.0 + roughness * sOverT );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		float albedoV = FON_DirectionalAlbedo( dotNV, roughness, A );
		float albedoL = FON_DirectionalAlbedo( dotNL, roughness, A );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		vec3 multiScatter = rhoMultiScatter * RECIPROCAL_PI
			* max( EON_EPSILON, 1.0 - albedoV )
			* max( EON_EPSILON, 1.0 - albedoL )
			/ max( EON_EPSILON, 1.0 - averageAlbedo );
		return singleScatter + multiScatter;
	}
	vec3 EON_DirectionalAlbedo( const in vec3 diffuseColor, const in float roughness, const in float dotNV ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return rho;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		float directionalAlbedo = FON_DirectionalAlbedo( dotNV, roughness, A );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		return rho * directionalAlbedo + rhoMultiScatter * ( 1.0 - directionalAlbedo );
	}
#endif
float V_GGX_SmithCorrelated( const in float alpha, const in float dotNL, const in float dotNV ) {
	float a2 = pow2( alpha );
	float gv = dotNL * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNV ) );
	float gl = dotNV * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNL ) );
	return 0.5 / max( gv + gl, EPSILON );
}
float D_GGX( const in float alpha, const in float dotNH ) {
	float a2 = pow2( alpha );
	float denom = pow2( dotNH ) * ( a2 - 1.0 ) + 1.0;
	return RECIPROCAL_PI * a2 / pow2( denom );
}
#ifdef USE_ANISOTROPY
	float V_GGX_SmithCorrelated_Anisotropic( const in float alphaT, const in float alphaB, const in float dotTV, const in float dotBV, const in float dotTL, const in float dotBL, const in float dotNV, const in float dotNL ) {
		float gv = dotNL * length( vec3( alphaT * dotTV, alphaB * dotBV, dotNV ) );
		float gl = dotNV * length( vec3( alphaT * dotTL, alphaB * dotBL, dotNL ) );
		return 0.5 / max( gv + gl, EPSILON );
	}
	float D_GGX_Anisotropic( const in float alphaT, const in float alphaB, const in float dotNH, const in float dotTH, const in float dotBH ) {
		float a2 = alphaT * alphaB;
		highp vec3 v = vec3( alphaB * dotTH, alphaT * dotBH, a2 * dotNH );
		highp float v2 = dot( v, v );
		float w2 = a2 / v2;
		return RECIPROCAL_PI * a2 * pow2 ( w2 );
	}
#endif
#ifdef USE_CLEARCOAT
	vec3 BRDF_GGX_Clearcoat( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material) {
		vec3 f0 = material.clearcoatF0;
		float f90 = material.clearcoatF90;
		float roughness = max( material.clearcoatRoughness, 0.045 );
		float alpha = pow2( roughness );
		vec3 halfDir = normalize( lightDir + viewDir );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float dotNH = saturate( dot( normal, halfDir ) );
		float dotVH = saturate( dot( viewDir, halfDir ) );
		vec3 F = F_Schlick( f0, f90, dotVH );
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
		return F * ( V * D );
	}
#endif
vec3 BRDF_GGX( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material ) {
	vec3 f0 = material.specularColorBlended;
	float f90 = material.specularF90;
	float roughness = max( material.roughness, 0.045 );
	float alpha = pow2( roughness );
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( f0, f90, dotVH );
	#ifdef USE_IRIDESCENCE
		F = mix( F, material.iridescenceFresnel, material.iridescence );
	#endif
	#ifdef USE_ANISOTROPY
		float dotTL = dot( material.anisotropyT, lightDir );
		float dotTV = dot( material.anisotropyT, viewDir );
		float dotTH = dot( material.anisotropyT, halfDir );
		float dotBL = dot( material.anisotropyB, lightDir );
		float dotBV = dot( material.anisotropyB, viewDir );
		float dotBH = dot( material.anisotropyB, halfDir );
		float alphaT = max( material.alphaT, alpha );
		float V = V_GGX_SmithCorrelated_Anisotropic( alphaT, alpha, dotTV, dotBV, dotTL, dotBL, dotNV, dotNL );
		float D = D_GGX_Anisotropic( alphaT, alpha, dotNH, dotTH, dotBH );
	#else
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
	#endif
	return F * ( V * D );
}
vec2 LTC_Uv( const in vec3 N, const in vec3 V, const in float roughness ) {
	const float LUT_SIZE = 64.0;
	const float LUT_SCALE = ( LUT_SIZE - 1.0 ) / LUT_SIZE;
	const float LUT_BIAS = 0.5 / LUT_SIZE;
	float dotNV = saturate( dot( N, V ) );
	vec2 uv = vec2( roughness, sqrt( 1.0 - dotNV ) );
	uv = uv * LUT_SCALE + LUT_BIAS;
	return uv;
}
float LTC_ClippedSphereFormFactor( const in vec3 f ) {
	float l = length( f );
	return max( ( l * l + f.z ) / ( l + 1.0 ), 0.0 );
}
vec3 LTC_EdgeVectorFormFactor( const in vec3 v1, const in vec3 v2 ) {
	float x = dot( v1, v2 );
	float y = abs( x );
	float a = 0.8543985 + ( 0.4965155 + 0.0145206 * y ) * y;
	float b = 3.4175940 + ( 4.1616724 + y ) * y;
	float v = a / b;
	float theta_sintheta = ( x > 0.0 ) ? v : 0.5 * inversesqrt( max( 1.0 - x * x, 1e-7 ) ) - v;
	return cross( v1, v2 ) * theta_sintheta;
}
vec3 LTC_Evaluate( const in vec3 N, const in vec3 V, const in vec3 P, const in mat3 mInv, const in vec3 rectCoords[ 4 ] ) {
	vec3 v1 = rectCoords[ 1 ] - rectCoords[ 0 ];
	vec3 v2 = rectCoords[ 3 ] - rectCoords[ 0 ];
	vec3 lightNormal = cross( v1, v2 );
	if( dot( lightNormal, P - rectCoords[ 0 ] ) < 0.0 ) return vec3( 0.0 );
	vec3 T1, T2;
	T1 = normalize( V - N * dot( V, N ) );
	T2 = - cross( N, T1 );
	mat3 mat = mInv * transpose( mat3( T1, T2, N ) );
	vec3 coords[ 4 ];
	coords[ 0 ] = mat * ( rectCoords[ 0 ] - P );
	coords[ 1 ] = mat * ( rectCoords[ 1 ] - P );
	coords[ 2 ] = mat * ( rectCoords[ 2 ] - P );
	coords[ 3 ] = mat * ( rectCoords[ 3 ] - P );
	coords[ 0 ] = normalize( coords[ 0 ] );
	coords[ 1 ] = normalize( coords[ 1 ] );
	coords[ 2 ] = normalize( coords[ 2 ] );
	coords[ 3 ] = normalize( coords[ 3 ] );
	vec3 vectorFormFactor = vec3( 0.0 );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 0 ], coords[ 1 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 1 ], coords[ 2 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 2 ], coords[ 3 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 3 ], coords[ 0 ] );
	float result = LTC_ClippedSphereFormFactor( vectorFormFactor );
	return vec3( result );
}
#if defined( USE_SHEEN )
float D_Charlie( float roughness, float dotNH ) {
	float alpha = pow2( roughness );
	float invAlpha = 1.0 / alpha;
	float cos2h = dotNH * dotNH;
	float sin2h = max( 1.0 - cos2h, 0.0078125 );
	return ( 2.0 + invAlpha ) * pow( sin2h, invAlpha * 0.5 ) / ( 2.0 * PI );
}
float V_Neubelt( float dotNV, float dotNL ) {
	return saturate( 1.0 / ( 4.0 * ( dotNL + dotNV - dotNL * dotNV ) ) );
}
vec3 BRDF_Sheen( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, vec3 sheenColor, const in float sheenRoughness ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float D = D_Charlie( sheenRoughness, dotNH );
	float V = V_Neubelt( dotNV, dotNL );
	return sheenColor * ( D * V );
}
#endif
float IBLSheenBRDF( const in vec3 normal, const in vec3 viewDir, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	float r2 = roughness * roughness;
	float rInv = 1.0 / ( roughness + 0.1 );
	float a = -1.9362 + 1.0678 * roughness + 0.4573 * r2 - 0.8469 * rInv;
	float b = -0.6014 + 0.5538 * roughness - 0.4670 * r2 - 0.1255 * rInv;
	float DG = exp( a * dotNV + b );
	return saturate( DG );
}
vec3 EnvironmentBRDF( const in vec3 normal, const in vec3 viewDir, const in vec3 specularColor, const in float specularF90, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	vec2 fab = texture2D( dfgLUT, vec2( roughness, dotNV ) ).rg;
	return specularColor * fab.x + specularF90 * fab.y;
}
#ifdef USE_IRIDESCENCE
void computeMultiscatteringIridescence( const in vec2 fab, const in vec3 specularColor, const in float specularF90, const in float iridescence, const in vec3 iridescenceF0, inout vec3 singleScatter, inout vec3 multiScatter ) {
#else
void computeMultiscattering( const in vec2 fab, const in vec3 specularColor, const in float specularF90, inout vec3 singleScatter, inout vec3 multiScatter ) {
#endif
	#ifdef USE_IRIDESCENCE
		vec3 Fr = mix( specularColor, iridescenceF0, iridescence );
	#else
		vec3 Fr = specularColor;
	#endif
	vec3 FssEss = Fr * fab.x + specularF90 * fab.y;
	float Ess = fab.x + fab.y;
	float Ems = 1.0 - Ess;
	vec3 Favg = Fr + ( 1.0 - Fr ) * 0.047619;	vec3 Fms = FssEss * Favg / ( 1.0 - Ems * Favg );
	singleScatter += FssEss;
	multiScatter += Fms * Ems;
}
#if NUM_RECT_AREA_LIGHTS > 0
	void RE_Direct_RectArea_Physical( const in RectAreaLight rectAreaLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
		vec3 normal = geometryNormal;
		vec3 viewDir = geometryViewDir;
		vec3 position = geometryPosition;
		vec3 lightPos = rectAreaLight.position;
		vec3 halfWidth = rectAreaLight.halfWidth;
		vec3 halfHeight = rectAreaLight.halfHeight;
		vec3 lightColor = rectAreaLight.color;
		float roughness = material.roughness;
		vec3 rectCoords[ 4 ];
		rectCoords[ 0 ] = lightPos + halfWidth - halfHeight;		rectCoords[ 1 ] = lightPos - halfWidth - halfHeight;
		rectCoords[ 2 ] = lightPos - halfWidth + halfHeight;
		rectCoords[ 3 ] = lightPos + halfWidth + halfHeight;
		vec2 uv = LTC_Uv( normal, viewDir, roughness );
		vec4 t1 = texture2D( ltc_1, uv );
		vec4 t2 = texture2D( ltc_2, uv );
		mat3 mInv = mat3(
			vec3( t1.x, 0, t1.y ),
			vec3(    0, 1,    0 ),
			vec3( t1.z, 0, t1.w )
		);
		vec3 fresnel = ( material.specularColorBlended * t2.x + ( material.specularF90 - material.specularColorBlended ) * t2.y );
		reflectedLight.directSpecular += lightColor * fresnel * LTC_Evaluate( normal, viewDir, position, mInv, rectCoords );
		reflectedLight.directDiffuse += lightColor * material.diffuseContribution * LTC_Evaluate( normal, viewDir, position, mat3( 1.0 ), rectCoords );
		#ifdef USE_CLEARCOAT
			vec3 Ncc = geometryClearcoatNormal;
			vec2 uvClearcoat = LTC_Uv( Ncc, viewDir, material.clearcoatRoughness );
			vec4 t1Clearcoat = texture2D( ltc_1, uvClearcoat );
			vec4 t2Clearcoat = texture2D( ltc_2, uvClearcoat );
			mat3 mInvClearcoat = mat3(
				vec3( t1Clearcoat.x, 0, t1Clearcoat.y ),
				vec3(             0, 1,             0 ),
				vec3( t1Clearcoat.z, 0, t1Clearcoat.w )
			);
			vec3 fresnelClearcoat = material.clearcoatF0 * t2Clearcoat.x + ( material.clearcoatF90 - material.clearcoatF0 ) * t2Clearcoat.y;
			clearcoatSpecularDirect += lightColor * fresnelClearcoat * LTC_Evaluate( Ncc, viewDir, position, mInvClearcoat, rectCoords );
		#endif
	}
#endif
void RE_Direct_Physical( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	#ifdef USE_CLEARCOAT
		float dotNLcc = saturate( dot( geometryClearcoatNormal, directLight.direction ) );
		vec3 ccIrradiance = dotNLcc * directLight.color;
		clearcoatSpecularDirect += ccIrradiance * BRDF_GGX_Clearcoat( directLight.direction, geometryViewDir, geometryClearcoatNormal, material );
	#endif
	#ifdef USE_SHEEN
 
 		sheenSpecularDirect += irradiance * BRDF_Sheen( directLight.direction, geometryViewDir, geometryNormal, material.sheenColor, material.sheenRoughness );
 
 		float sheenAlbedoV = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
 		float sheenAlbedoL = IBLSheenBRDF( geometryNormal, directLight.direction, material.sheenRoughness );
 
 		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * max( sheenAlbedoV, sheenAlbedoL );
 
 		irradiance *= sheenEnergyComp;
 
 	#endif
	vec3 specularBRDF = BRDF_GGX( directLight.direction, geometryViewDir, geometryNormal, material );
	#ifdef USE_RETROREFLECTION
		vec3 retroViewDir = reflect( - geometryViewDir, geometryNormal );
		vec3 retroSpecularBRDF = BRDF_GGX( directLight.direction, retroViewDir, geometryNormal, material );
		specularBRDF = mix( specularBRDF, retroSpecularBRDF, saturate( material.retroreflectivity ) );
	#endif
	reflectedLight.directSpecular += irradiance * specularBRDF * material.multiScatteringCompensation;
	vec3 halfDir = normalize( directLight.direction + geometryViewDir );
	float dotVH = saturate( dot( geometryViewDir, halfDir ) );
	vec3 F = F_Schlick( material.specularColor, material.specularF90, dotVH );
	#ifdef USE_RETROREFLECTION
		vec3 retroHalfDir = normalize( directLight.direction + retroViewDir );
		float dotRetroVH = saturate( dot( retroViewDir, retroHalfDir ) );
		vec3 retroF = F_Schlick( material.specularColor, material.specularF90, dotRetroVH );
		F = mix( F, retroF, saturate( material.retroreflectivity ) );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		vec3 diffuseBRDF = BRDF_EON( directLight.direction, geometryViewDir, geometryNormal, material.diffuseColor, material.diffuseRoughness ) * ( 1.0 - material.metalness );
	#else
		vec3 diffuseBRDF = BRDF_Lambert( material.diffuseContribution );
	#endif
	reflectedLight.directDiffuse += irradiance * diffuseBRDF * ( 1.0 - F );
}
void RE_IndirectDiffuse_Physical( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 singleScattering = vec3( 0.0 );
	vec3 multiScattering = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScattering, multiScattering );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScattering, multiScattering );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuseAlbedo = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness );
		vec3 diffuse = irradiance * RECIPROCAL_PI * diffuseAlbedo * ( 1.0 - singleScattering - multiScattering );
	#else
		vec3 diffuse = irradiance * BRDF_Lambert( material.diffuseContribution ) * ( 1.0 - singleScattering - multiScattering );
	#endif
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		sheenSpecularIndirect += irradiance * material.sheenColor * sheenAlbedo * RECIPROCAL_PI;
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		diffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectDiffuse += diffuse;
}
void RE_IndirectSpecular_Physical( const in vec3 radiance, const in vec3 irradiance, const in vec3 clearcoatRadiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
	#ifdef USE_CLEARCOAT
		clearcoatSpecularIndirect += clearcoatRadiance * EnvironmentBRDF( geometryClearcoatNormal, geometryViewDir, material.clearcoatF0, material.clearcoatF90, material.clearcoatRoughness );
	#endif
	#ifdef USE_SHEEN
		sheenSpecularIndirect += irradiance * material.sheenColor * IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness ) * RECIPROCAL_PI;
 	#endif
	vec3 singleScatteringDielectric = vec3( 0.0 );
	vec3 multiScatteringDielectric = vec3( 0.0 );
	vec3 singleScatteringMetallic = vec3( 0.0 );
	vec3 multiScatteringMetallic = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscatteringIridescence( material.dfg, material.diffuseColor, material.specularF90, material.iridescence, material.iridescenceF0Metallic, singleScatteringMetallic, multiScatteringMetallic );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscattering( material.dfg, material.diffuseColor, material.specularF90, singleScatteringMetallic, multiScatteringMetallic );
	#endif
	vec3 singleScattering = mix( singleScatteringDielectric, singleScatteringMetallic, material.metalness );
	vec3 multiScattering = mix( multiScatteringDielectric, multiScatteringMetallic, material.metalness );
	vec3 totalScatteringDielectric = singleScatteringDielectric + multiScatteringDielectric;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuse = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness ) * ( 1.0 - totalScatteringDielectric );
	#else
		vec3 diffuse = material.diffuseContribution * ( 1.0 - totalScatteringDielectric );
	#endif
	vec3 cosineWeightedIrradiance = irradiance * RECIPROCAL_PI;
	vec3 indirectSpecular = radiance * singleScattering;
	indirectSpecular += multiScattering * cosineWeightedIrradiance;
	vec3 indirectDiffuse = diffuse * cosineWeightedIrradiance;
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		indirectSpecular *= sheenEnergyComp;
		indirectDiffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectSpecular += indirectSpecular;
	reflectedLight.indirectDiffuse += indirectDiffuse;
}
#define RE_Direct				RE_Direct_Physical
#define RE_Direct_RectArea		RE_Direct_RectArea_Physical
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Physical
#define RE_IndirectSpecular		RE_IndirectSpecular_Physical
float computeSpecularOcclusion( const in float dotNV, const in float ambientOcclusion, const in float roughness ) {
	return saturate( pow( dotNV + ambientOcclusion, exp2( - 16.0 * roughness - 1.0 ) ) - 1.0 + ambientOcclusion );
}`,CR=`
vec3 geometryPosition = - vViewPosition;
vec3 geometryNormal = normal;
vec3 geometryViewDir = ( isOrthographic ) ? vec3( 0, 0, 1 ) : normalize( vViewPosition );
vec3 geometryClearcoatNormal = vec3( 0.0 );
#ifdef USE_CLEARCOAT
	geometryClearcoatNormal = clearcoatNormal;
#endif
#ifdef USE_IRIDESCENCE
	float dotNVi = saturate( dot( normal, geometryViewDir ) );
	if ( material.iridescenceThickness == 0.0 ) {
		material.iridescence = 0.0;
	} else {
		material.iridescence = saturate( material.iridescence );
	}
	if ( material.iridescence > 0.0 ) {
		vec3 iridescenceFresnelDielectric = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.specularColor );
		vec3 iridescenceFresnelMetallic = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.diffuseColor );
		material.iridescenceFresnel = mix( iridescenceFresnelDielectric, iridescenceFresnelMetallic, material.metalness );
		material.iridescenceF0Dielectric = Schlick_to_F0( iridescenceFresnelDielectric, 1.0, dotNVi );
		material.iridescenceF0Metallic = Schlick_to_F0( iridescenceFresnelMetallic, 1.0, dotNVi );
	}
#endif
#ifdef STANDARD
	float dotNVms = saturate( dot( geometryNormal, geometryViewDir ) );
	material.dfg = texture2D( dfgLUT, vec2( material.roughness, dotNVms ) ).rg;
	#if ( NUM_SUN_LIGHTS > 0 || NUM_DIR_LIGHTS > 0 || NUM_POINT_LIGHTS > 0 || NUM_SPOT_LIGHTS > 0 )
		float EssMs = material.dfg.x + material.dfg.y;
		material.multiScatteringCompensation = 1.0 + material.specularColorBlended * ( 1.0 / EssMs - 1.0 );
	#endif
#endif
IncidentLight directLight;
#if ( NUM_POINT_LIGHTS > 0 ) && defined( RE_Direct )
	PointLight pointLight;
	#if defined( USE_SHADOWMAP ) && NUM_POINT_LIGHT_SHADOWS > 0
	PointLightShadow pointLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHTS; i ++ ) {
		pointLight = pointLights[ i ];
		getPointLightInfo( pointLight, geometryPosition, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_POINT_LIGHT_SHADOWS ) && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
		pointLightShadow = pointLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getPointShadow( pointShadowMap[ i ], pointLightShadow.shadowMapSize, pointLightShadow.shadowIntensity, pointLightShadow.shadowBias, pointLightShadow.shadowRadius, vPointShadowCoord[ i ], pointLightShadow.shadowCameraNear, pointLightShadow.shadowCameraFar ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SPOT_LIGHTS > 0 ) && defined( RE_Direct )
	SpotLight spotLight;
	vec4 spotColor;
	vec3 spotLightCoord;
	bool inSpotLightMap;
	#if defined( USE_SHADOWMAP ) && NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHTS; i ++ ) {
		spotLight = spotLights[ i ];
		getSpotLightInfo( spotLight, geometryPosition, directLight );
		#if ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#define SPOT_LIGHT_MAP_INDEX UNROLLED_LOOP_INDEX
		#elif ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		#define SPOT_LIGHT_MAP_INDEX NUM_SPOT_LIGHT_MAPS
		#else
		#define SPOT_LIGHT_MAP_INDEX ( UNROLLED_LOOP_INDEX - NUM_SPOT_LIGHT_SHADOWS + NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#endif
		#if ( SPOT_LIGHT_MAP_INDEX < NUM_SPOT_LIGHT_MAPS )
			spotLightCoord = vSpotLightCoord[ i ].xyz / vSpotLightCoord[ i ].w;
			inSpotLightMap = all( lessThan( abs( spotLightCoord * 2. - 1. ), vec3( 1.0 ) ) );
			spotColor = texture2D( spotLightMap[ SPOT_LIGHT_MAP_INDEX ], spotLightCoord.xy );
			directLight.color = inSpotLightMap ? directLight.color * spotColor.rgb : directLight.color;
		#endif
		#undef SPOT_LIGHT_MAP_INDEX
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		spotLightShadow = spotLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( spotShadowMap[ i ], spotLightShadow.shadowMapSize, spotLightShadow.shadowIntensity, spotLightShadow.shadowBias, spotLightShadow.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SUN_LIGHTS > 0 ) && defined( RE_Direct )
	SunLight sunLight;
	#if defined( USE_SHADOWMAP ) && NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHTS; i ++ ) {
		sunLight = sunLights[ i ];
		getSunLightInfo( sunLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SUN_LIGHT_SHADOWS )
		sunLightShadow = sunLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getSunShadow( sunShadowMap[ i ], sunLightShadow, UNROLLED_LOOP_INDEX ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_DIR_LIGHTS > 0 ) && defined( RE_Direct )
	DirectionalLight directionalLight;
	#if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHTS; i ++ ) {
		directionalLight = directionalLights[ i ];
		getDirectionalLightInfo( directionalLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_DIR_LIGHT_SHADOWS )
		directionalLightShadow = directionalLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( directionalShadowMap[ i ], directionalLightShadow.shadowMapSize, directionalLightShadow.shadowIntensity, directionalLightShadow.shadowBias, directionalLightShadow.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_RECT_AREA_LIGHTS > 0 ) && defined( RE_Direct_RectArea )
	RectAreaLight rectAreaLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_RECT_AREA_LIGHTS; i ++ ) {
		rectAreaLight = rectAreaLights[ i ];
		RE_Direct_RectArea( rectAreaLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if defined( RE_IndirectDiffuse )
	vec3 iblIrradiance = vec3( 0.0 );
	vec3 irradiance = getAmbientLightIrradiance( ambientLightColor );
	#if defined( USE_LIGHT_PROBES )
		irradiance += getLightProbeIrradiance( lightProbe, geometryNormal );
	#endif
	#if ( NUM_HEMI_LIGHTS > 0 )
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_HEMI_LIGHTS; i ++ ) {
			irradiance += getHemisphereLightIrradiance( hemisphereLights[ i ], geometryNormal );
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_LIGHT_PROBE_GRIDS > 0
		vec3 probeWorldPos = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
		vec3 probeWorldNormal = transformNormalByInverseViewMatrix( geometryNormal, viewMatrix );
		int probeGrid = - 1;
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( isInsideLightProbeGrid( probeWorldPos, probeWorldNormal, probesMin[ i ], probesMax[ i ], probesResolution[ i ] ) ) probeGrid = UNROLLED_LOOP_INDEX;
		}
		#pragma unroll_loop_end
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( probeGrid == UNROLLED_LOOP_INDEX ) irradiance += getLightProbeGridIrradiance( probesSH[ i ], probesMin[ i ], probesMax[ i ], probesResolution[ i ], probeWorldPos, probeWorldNormal );
		}
		#pragma unroll_loop_end
	#endif
#endif
#if defined( RE_IndirectSpecular )
	vec3 radiance = vec3( 0.0 );
	vec3 clearcoatRadiance = vec3( 0.0 );
#endif`,RR=`#if defined( RE_IndirectDiffuse )
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		vec3 lightMapIrradiance = lightMapTexel.rgb * lightMapIntensity;
		irradiance += lightMapIrradiance;
	#endif
	#if defined( USE_ENVMAP ) && defined( ENVMAP_TYPE_PMREM )
		#if defined( STANDARD ) || defined( LAMBERT ) || defined( PHONG )
			iblIrradiance += getIBLIrradiance( geometryNormal );
		#endif
	#endif
#endif
#if defined( USE_ENVMAP ) && defined( RE_IndirectSpecular )
	#ifdef USE_ANISOTROPY
		vec3 iblRadiance = getIBLAnisotropyRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
	#else
		vec3 iblRadiance = getIBLRadiance( geometryViewDir, geometryNormal, material.roughness );
	#endif
	#ifdef USE_RETROREFLECTION
		#ifdef USE_ANISOTROPY
			vec3 retroIBLRadiance = getIBLAnisotropyRetroRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
		#else
			vec3 retroIBLRadiance = getIBLRetroRadiance( geometryViewDir, geometryNormal, material.roughness );
		#endif
		iblRadiance = mix( iblRadiance, retroIBLRadiance, saturate( material.retroreflectivity ) );
	#endif
	radiance += iblRadiance;
	#ifdef USE_CLEARCOAT
		clearcoatRadiance += getIBLRadiance( geometryViewDir, geometryClearcoatNormal, material.clearcoatRoughness );
	#endif
#endif`,IR=`#if defined( RE_IndirectDiffuse )
	#if defined( LAMBERT ) || defined( PHONG )
		irradiance += iblIrradiance;
	#endif
	RE_IndirectDiffuse( irradiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif
#if defined( RE_IndirectSpecular )
	RE_IndirectSpecular( radiance, iblIrradiance, clearcoatRadiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif`,PR=`#if NUM_LIGHT_PROBE_GRIDS > 0
uniform highp sampler3D probesSH[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMin[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMax[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesResolution[ NUM_LIGHT_PROBE_GRIDS ];
bool isInsideLightProbeGrid( vec3 worldPos, vec3 worldNormal, vec3 probesMin, vec3 probesMax, vec3 probesResolution ) {
	vec3 spacing = ( probesMax - probesMin ) / probesResolution;
	vec3 samplePos = worldPos + worldNormal * spacing * 0.5;
	vec3 margin = spacing * 0.01;
	return all( greaterThanEqual( samplePos, probesMin - margin ) ) && all( lessThanEqual( samplePos, probesMax + margin ) );
}
vec3 getLightProbeGridIrradiance( highp sampler3D probesSH, vec3 probesMin, vec3 probesMax, vec3 probesResolution, vec3 worldPos, vec3 worldNormal ) {
	vec3 res = probesResolution;
	vec3 gridRange = probesMax - probesMin;
	vec3 probeSpacing = gridRange / res;
	vec3 samplePos = worldPos + worldNormal * probeSpacing * 0.5;
	vec3 uvw = clamp( ( samplePos - probesMin ) / gridRange, 0.5 / res, 1.0 - 0.5 / res );
	float nz          = res.z;
	float paddedSlices = nz + 2.0;
	float atlasDepth  = 7.0 * paddedSlices;
	float uvZBase     = uvw.z * nz + 1.0;
	vec4 s0 = texture( probesSH, vec3( uvw.xy, ( uvZBase                       ) / atlasDepth ) );
	vec4 s1 = texture( probesSH, vec3( uvw.xy, ( uvZBase +       paddedSlices   ) / atlasDepth ) );
	vec4 s2 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 2.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s3 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 3.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s4 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 4.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s5 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 5.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s6 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 6.0 * paddedSlices   ) / atlasDepth ) );
	vec3 c0 = s0.xyz;
	vec3 c1 = vec3( s0.w, s1.xy );
	vec3 c2 = vec3( s1.zw, s2.x );
	vec3 c3 = s2.yzw;
	vec3 c4 = s3.xyz;
	vec3 c5 = vec3( s3.w, s4.xy );
	vec3 c6 = vec3( s4.zw, s5.x );
	vec3 c7 = s5.yzw;
	vec3 c8 = s6.xyz;
	float x = worldNormal.x, y = worldNormal.y, z = worldNormal.z;
	vec3 result = c0 * 0.886227;
	result += c1 * 2.0 * 0.511664 * y;
	result += c2 * 2.0 * 0.511664 * z;
	result += c3 * 2.0 * 0.511664 * x;
	result += c4 * 2.0 * 0.429043 * x * y;
	result += c5 * 2.0 * 0.429043 * y * z;
	result += c6 * ( 0.743125 * z * z - 0.247708 );
	result += c7 * 2.0 * 0.429043 * x * z;
	result += c8 * 0.429043 * ( x * x - y * y );
	return max( result, vec3( 0.0 ) );
}
#endif`,LR=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	gl_FragDepth = vIsPerspective == 0.0 ? gl_FragCoord.z : log2( vFragDepth ) * logDepthBufFC * 0.5;
#endif`,NR=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	uniform float logDepthBufFC;
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,DR=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,FR=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	vFragDepth = 1.0 + gl_Position.w;
	vIsPerspective = float( isPerspectiveMatrix( projectionMatrix ) );
#endif`,UR=`#ifdef USE_MAP
	vec4 sampledDiffuseColor = texture2D( map, vMapUv );
	#ifdef DECODE_VIDEO_TEXTURE
		sampledDiffuseColor = sRGBTransferEOTF( sampledDiffuseColor );
	#endif
	diffuseColor *= sampledDiffuseColor;
#endif`,OR=`#ifdef USE_MAP
	uniform sampler2D map;
#endif`,BR=`#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
	#if defined( USE_POINTS_UV )
		vec2 uv = vUv;
	#else
		vec2 uv = ( uvTransform * vec3( gl_PointCoord.x, 1.0 - gl_PointCoord.y, 1 ) ).xy;
	#endif
#endif
#ifdef USE_MAP
	diffuseColor *= texture2D( map, uv );
#endif
#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, uv ).g;
#endif`,kR=`#if defined( USE_POINTS_UV )
	varying vec2 vUv;
#else
	#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
		uniform mat3 uvTransform;
	#endif
#endif
#ifdef USE_MAP
	uniform sampler2D map;
#endif
#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,zR=`float metalnessFactor = metalness;
#ifdef USE_METALNESSMAP
	vec4 texelMetalness = texture2D( metalnessMap, vMetalnessMapUv );
	metalnessFactor *= texelMetalness.b;
#endif`,GR=`#ifdef USE_METALNESSMAP
	uniform sampler2D metalnessMap;
#endif`,VR=`#ifdef USE_INSTANCING_MORPH
	float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	float morphTargetBaseInfluence = texelFetch( morphTexture, ivec2( 0, gl_InstanceID ), 0 ).r;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		morphTargetInfluences[i] =  texelFetch( morphTexture, ivec2( i + 1, gl_InstanceID ), 0 ).r;
	}
#endif`,HR=`#if defined( USE_MORPHCOLORS )
	#if defined( USE_COLOR_ALPHA )
		vColor *= morphTargetBaseInfluence;
	#elif defined( USE_COLOR )
		vColor.rgb *= morphTargetBaseInfluence;
	#endif
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		#if defined( USE_COLOR_ALPHA )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor += getMorph( gl_VertexID, i, 2 ) * morphTargetInfluences[ i ];
		#elif defined( USE_COLOR )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor.rgb += getMorph( gl_VertexID, i, 2 ).rgb * morphTargetInfluences[ i ];
		#endif
	}
#endif`,WR=`#ifdef USE_MORPHNORMALS
	objectNormal *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) objectNormal += getMorph( gl_VertexID, i, 1 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,$R=`#ifdef USE_MORPHTARGETS
	#ifndef USE_INSTANCING_MORPH
		uniform float morphTargetBaseInfluence;
		uniform float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	#endif
	uniform sampler2DArray morphTargetsTexture;
	uniform ivec2 morphTargetsTextureSize;
	vec4 getMorph( const in int vertexIndex, const in int morphTargetIndex, const in int offset ) {
		int texelIndex = vertexIndex * MORPHTARGETS_TEXTURE_STRIDE + offset;
		int y = texelIndex / morphTargetsTextureSize.x;
		int x = texelIndex - y * morphTargetsTextureSize.x;
		ivec3 morphUV = ivec3( x, y, morphTargetIndex );
		return texelFetch( morphTargetsTexture, morphUV, 0 );
	}
#endif`,XR=`#ifdef USE_MORPHTARGETS
	transformed *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) transformed += getMorph( gl_VertexID, i, 0 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,qR=`float faceDirection = gl_FrontFacing ? 1.0 : - 1.0;
#ifdef FLAT_SHADED
	vec3 fdx = dFdx( vViewPosition );
	vec3 fdy = dFdy( vViewPosition );
	vec3 normal = normalize( cross( fdx, fdy ) );
#else
	vec3 normal = normalize( vNormal );
	#ifdef DOUBLE_SIDED
		normal *= faceDirection;
	#endif
#endif
#if defined( USE_NORMALMAP_TANGENTSPACE ) || defined( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY )
	#ifdef USE_TANGENT
		mat3 tbn = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn = getTangentFrame( - vViewPosition, normal,
		#if defined( USE_NORMALMAP )
			vNormalMapUv
		#elif defined( USE_CLEARCOAT_NORMALMAP )
			vClearcoatNormalMapUv
		#else
			vUv
		#endif
		);
	#endif
	#ifdef DOUBLE_SIDED
		tbn[0] *= faceDirection;
		tbn[1] *= faceDirection;
	#endif
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	#ifdef USE_TANGENT
		mat3 tbn2 = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn2 = getTangentFrame( - vViewPosition, normal, vClearcoatNormalMapUv );
	#endif
	#ifdef DOUBLE_SIDED
		tbn2[0] *= faceDirection;
		tbn2[1] *= faceDirection;
	#endif
#endif
vec3 nonPerturbedNormal = normal;`,YR=`#ifdef USE_NORMALMAP_OBJECTSPACE
	normal = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#ifdef FLIP_SIDED
		normal = - normal;
	#endif
	#ifdef DOUBLE_SIDED
		normal = normal * faceDirection;
	#endif
	normal = normalize( normalMatrix * normal );
#elif defined( USE_NORMALMAP_TANGENTSPACE )
	vec3 mapN = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#if defined( USE_PACKED_NORMALMAP )
		mapN = vec3( mapN.xy, sqrt( saturate( 1.0 - dot( mapN.xy, mapN.xy ) ) ) );
	#endif
	mapN.xy *= normalScale;
	normal = normalize( tbn * mapN );
#elif defined( USE_BUMPMAP )
	normal = perturbNormalArb( - vViewPosition, normal, dHdxy_fwd(), faceDirection );
#endif`,ZR=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,JR=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,KR=`#ifndef FLAT_SHADED
	vNormal = normalize( transformedNormal );
	#ifdef USE_TANGENT
		vTangent = normalize( transformedTangent );
		vBitangent = normalize( cross( vNormal, vTangent ) * tangent.w );
		#ifdef FLIP_SIDED
			vBitangent = - vBitangent;
		#endif
	#endif
#endif`,jR=`#ifdef USE_NORMALMAP
	uniform sampler2D normalMap;
	uniform vec2 normalScale;
#endif
#ifdef USE_NORMALMAP_OBJECTSPACE
	uniform mat3 normalMatrix;
#endif
#if ! defined ( USE_TANGENT ) && ( defined ( USE_NORMALMAP_TANGENTSPACE ) || defined ( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY ) )
	mat3 getTangentFrame( vec3 eye_pos, vec3 surf_norm, vec2 uv ) {
		vec3 q0 = dFdx( eye_pos.xyz );
		vec3 q1 = dFdy( eye_pos.xyz );
		vec2 st0 = dFdx( uv.st );
		vec2 st1 = dFdy( uv.st );
		vec3 N = surf_norm;
		vec3 q1perp = cross( q1, N );
		vec3 q0perp = cross( N, q0 );
		vec3 T = q1perp * st0.x + q0perp * st1.x;
		vec3 B = q1perp * st0.y + q0perp * st1.y;
		float det = max( dot( T, T ), dot( B, B ) );
		float scale = ( det == 0.0 ) ? 0.0 : inversesqrt( det );
		return mat3( T * scale, B * scale, N );
	}
#endif`,QR=`#ifdef USE_CLEARCOAT
	vec3 clearcoatNormal = nonPerturbedNormal;
#endif`,tI=`#ifdef USE_CLEARCOAT_NORMALMAP
	vec3 clearcoatMapN = texture2D( clearcoatNormalMap, vClearcoatNormalMapUv ).xyz * 2.0 - 1.0;
	clearcoatMapN.xy *= clearcoatNormalScale;
	clearcoatNormal = normalize( tbn2 * clearcoatMapN );
#endif`,eI=`#ifdef USE_CLEARCOATMAP
	uniform sampler2D clearcoatMap;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform sampler2D clearcoatNormalMap;
	uniform vec2 clearcoatNormalScale;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform sampler2D clearcoatRoughnessMap;
#endif`,nI=`#ifdef USE_IRIDESCENCEMAP
	uniform sampler2D iridescenceMap;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform sampler2D iridescenceThicknessMap;
#endif`,iI=`#ifdef OPAQUE
diffuseColor.a = 1.0;
#endif
#ifdef USE_TRANSMISSION
diffuseColor.a *= material.transmissionAlpha;
#endif
gl_FragColor = vec4( outgoingLight, diffuseColor.a );`,rI=`vec3 packNormalToRGB( const in vec3 normal ) {
	return normalize( normal ) * 0.5 + 0.5;
}
vec3 unpackRGBToNormal( const in vec3 rgb ) {
	return 2.0 * rgb.xyz - 1.0;
}
const float PackUpscale = 256. / 255.;const float UnpackDownscale = 255. / 256.;const float ShiftRight8 = 1. / 256.;
const float Inv255 = 1. / 255.;
const vec4 PackFactors = vec4( 1.0, 256.0, 256.0 * 256.0, 256.0 * 256.0 * 256.0 );
const vec2 UnpackFactors2 = vec2( UnpackDownscale, 1.0 / PackFactors.g );
const vec3 UnpackFactors3 = vec3( UnpackDownscale / PackFactors.rg, 1.0 / PackFactors.b );
const vec4 UnpackFactors4 = vec4( UnpackDownscale / PackFactors.rgb, 1.0 / PackFactors.a );
vec4 packDepthToRGBA( const in float v ) {
	if( v <= 0.0 )
		return vec4( 0., 0., 0., 0. );
	if( v >= 1.0 )
		return vec4( 1., 1., 1., 1. );
	float vuf;
	float af = modf( v * PackFactors.a, vuf );
	float bf = modf( vuf * ShiftRight8, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec4( vuf * Inv255, gf * PackUpscale, bf * PackUpscale, af );
}
vec3 packDepthToRGB( const in float v ) {
	if( v <= 0.0 )
		return vec3( 0., 0., 0. );
	if( v >= 1.0 )
		return vec3( 1., 1., 1. );
	float vuf;
	float bf = modf( v * PackFactors.b, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec3( vuf * Inv255, gf * PackUpscale, bf );
}
vec2 packDepthToRG( const in float v ) {
	if( v <= 0.0 )
		return vec2( 0., 0. );
	if( v >= 1.0 )
		return vec2( 1., 1. );
	float vuf;
	float gf = modf( v * 256., vuf );
	return vec2( vuf * Inv255, gf );
}
float unpackRGBAToDepth( const in vec4 v ) {
	return dot( v, UnpackFactors4 );
}
float unpackRGBToDepth( const in vec3 v ) {
	return dot( v, UnpackFactors3 );
}
float unpackRGToDepth( const in vec2 v ) {
	return v.r * UnpackFactors2.r + v.g * UnpackFactors2.g;
}
vec4 pack2HalfToRGBA( const in vec2 v ) {
	vec4 r = vec4( v.x, fract( v.x * 255.0 ), v.y, fract( v.y * 255.0 ) );
	return vec4( r.x - r.y / 255.0, r.y, r.z - r.w / 255.0, r.w );
}
vec2 unpackRGBATo2Half( const in vec4 v ) {
	return vec2( v.x + ( v.y / 255.0 ), v.z + ( v.w / 255.0 ) );
}
float viewZToOrthographicDepth( const in float viewZ, const in float near, const in float far ) {
	return ( viewZ + near ) / ( near - far );
}
float orthographicDepthToViewZ( const in float depth, const in float near, const in float far ) {
	#ifdef USE_REVERSED_DEPTH_BUFFER
	
		return depth * ( far - near ) - far;
	#else
		return depth * ( near - far ) - near;
	#endif
}
float viewZToPerspectiveDepth( const in float viewZ, const in float near, const in float far ) {
	return ( ( near + viewZ ) * far ) / ( ( far - near ) * viewZ );
}
float perspectiveDepthToViewZ( const in float depth, const in float near, const in float far ) {
	
	#ifdef USE_REVERSED_DEPTH_BUFFER
		return ( near * far ) / ( ( near - far ) * depth - near );
	#else
		return ( near * far ) / ( ( far - near ) * depth - far );
	#endif
}`,sI=`#ifdef PREMULTIPLIED_ALPHA
	gl_FragColor.rgb *= gl_FragColor.a;
#endif`,oI=`vec4 mvPosition = vec4( transformed, 1.0 );
#ifdef USE_BATCHING
	mvPosition = batchingMatrix * mvPosition;
#endif
#ifdef USE_INSTANCING
	mvPosition = instanceMatrix * mvPosition;
#endif
mvPosition = modelViewMatrix * mvPosition;
gl_Position = projectionMatrix * mvPosition;`,aI=`#ifdef DITHERING
	gl_FragColor.rgb = dithering( gl_FragColor.rgb );
#endif`,cI=`#ifdef DITHERING
	vec3 dithering( vec3 color ) {
		float grid_position = rand( gl_FragCoord.xy );
		vec3 dither_shift_RGB = vec3( 0.25 / 255.0, -0.25 / 255.0, 0.25 / 255.0 );
		dither_shift_RGB = mix( 2.0 * dither_shift_RGB, -2.0 * dither_shift_RGB, grid_position );
		return color + dither_shift_RGB;
	}
#endif`,lI=`float roughnessFactor = roughness;
#ifdef USE_ROUGHNESSMAP
	vec4 texelRoughness = texture2D( roughnessMap, vRoughnessMapUv );
	roughnessFactor *= texelRoughness.g;
#endif`,uI=`#ifdef USE_ROUGHNESSMAP
	uniform sampler2D roughnessMap;
#endif`,fI=`#if NUM_SPOT_LIGHT_COORDS > 0
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#if NUM_SPOT_LIGHT_MAPS > 0
	uniform sampler2D spotLightMap[ NUM_SPOT_LIGHT_MAPS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		#define SUN_LIGHT_CASCADES 2
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#else
			uniform sampler2D sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#endif
		uniform mat4 sunShadowMatrix[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		uniform vec4 sunShadowCascade[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
		struct SunLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SunLightShadow sunLightShadows[ NUM_SUN_LIGHT_SHADOWS ];
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#else
			uniform sampler2D directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#endif
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#else
			uniform sampler2D spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#endif
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform samplerCubeShadow pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#elif defined( SHADOWMAP_TYPE_BASIC )
			uniform samplerCube pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#endif
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float interleavedGradientNoise( vec2 position ) {
			return fract( 52.9829189 * fract( dot( position, vec2( 0.06711056, 0.00583715 ) ) ) );
		}
		vec2 vogelDiskSample( int sampleIndex, int samplesCount, float phi ) {
			const float goldenAngle = 2.399963229728653;
			float r = sqrt( ( float( sampleIndex ) + 0.5 ) / float( samplesCount ) );
			float theta = float( sampleIndex ) * goldenAngle + phi;
			return vec2( cos( theta ), sin( theta ) ) * r;
		}
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float getShadow( sampler2DShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 texelSize = vec2( 1.0 ) / shadowMapSize;
				vec2 radius = shadowRadius * texelSize;
				float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
				shadow = (
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 0, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 1, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 2, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 3, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 4, 5, phi ) * radius, shadowCoord.z ) )
				) * 0.2;
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#elif defined( SHADOWMAP_TYPE_VSM )
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 distribution = texture2D( shadowMap, shadowCoord.xy ).rg;
				float mean = distribution.x;
				float variance = distribution.y * distribution.y;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					float hard_shadow = step( mean, shadowCoord.z );
				#else
					float hard_shadow = step( shadowCoord.z, mean );
				#endif
				
				if ( hard_shadow == 1.0 ) {
					shadow = 1.0;
				} else {
					variance = max( variance, 0.0000001 );
					float d = shadowCoord.z - mean;
					float p_max = variance / ( variance + d * d );
					p_max = clamp( ( p_max - 0.3 ) / 0.65, 0.0, 1.0 );
					shadow = max( hard_shadow, p_max );
				}
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#else
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				float depth = texture2D( shadowMap, shadowCoord.xy ).r;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					shadow = step( depth, shadowCoord.z );
				#else
					shadow = step( shadowCoord.z, depth );
				#endif
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#endif
	#if NUM_SUN_LIGHT_SHADOWS > 0
		float getSunShadow(
			#if defined( SHADOWMAP_TYPE_PCF )
				sampler2DShadow shadowMap,
			#else
				sampler2D shadowMap,
			#endif
			SunLightShadow sunLightShadow,
			int shadowIndex
		) {
			vec4 shadowWorldPosition = vec4( vSunShadowWorldPosition.xyz + vSunShadowWorldNormal * sunLightShadow.shadowNormalBias, 1.0 );
			float viewDepth = vSunShadowWorldPosition.w;
			int cascadeOffset = shadowIndex * SUN_LIGHT_CASCADES;
			float shadow = 1.0;
			for ( int i = SUN_LIGHT_CASCADES - 1; i >= 0; i -- ) {
				vec4 cascade = sunShadowCascade[ cascadeOffset + i ];
				if ( viewDepth >= cascade.x && viewDepth < cascade.y ) {
					float cascadeShadow = getShadow(
						shadowMap,
						sunLightShadow.shadowMapSize,
						sunLightShadow.shadowIntensity,
						sunLightShadow.shadowBias,
						sunLightShadow.shadowRadius,
						sunShadowMatrix[ cascadeOffset + i ] * shadowWorldPosition
					);
					shadow = mix( cascadeShadow, shadow, smoothstep( cascade.z, cascade.y, viewDepth ) );
				}
			}
			return shadow;
		}
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
	#if defined( SHADOWMAP_TYPE_PCF )
	float getPointShadow( samplerCubeShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 bd3D = normalize( lightToPosition );
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float lightDistance = length( lightToPosition );
			float depthRange = shadowCameraFar - shadowCameraNear;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				float depthA = - shadowCameraNear / depthRange - shadowBias;
				float depthB = shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#else
				float depthA = shadowCameraFar / depthRange + shadowBias;
				float depthB = - shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#endif
			float texelSize = shadowRadius / shadowMapSize.x;
			vec3 absDir = abs( bd3D );
			vec3 tangent = absDir.x > absDir.z ? vec3( 0.0, 1.0, 0.0 ) : vec3( 1.0, 0.0, 0.0 );
			tangent = normalize( cross( bd3D, tangent ) );
			vec3 bitangent = cross( bd3D, tangent );
			float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
			shadow = 0.0;
			for ( int i = 0; i < 5; i ++ ) {
				vec2 offset = vogelDiskSample( i, 5, phi );
				vec3 direction = bd3D + ( tangent * offset.x + bitangent * offset.y ) * texelSize;
				vec3 absDirection = abs( direction );
				float dp = depthA + depthB / max( max( absDirection.x, absDirection.y ), absDirection.z );
				shadow += texture( shadowMap, vec4( direction, dp ) );
			}
			shadow *= 0.2;
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#elif defined( SHADOWMAP_TYPE_BASIC )
	float getPointShadow( samplerCube shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float dp = ( shadowCameraFar * ( viewSpaceZ - shadowCameraNear ) ) / ( viewSpaceZ * ( shadowCameraFar - shadowCameraNear ) );
			dp += shadowBias;
			vec3 bd3D = normalize( lightToPosition );
			float depth = textureCube( shadowMap, bd3D ).r;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				depth = 1.0 - depth;
			#endif
			shadow = step( dp, depth );
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#endif
	#endif
#endif`,hI=`#if NUM_SPOT_LIGHT_COORDS > 0
	uniform mat4 spotLightMatrix[ NUM_SPOT_LIGHT_COORDS ];
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		uniform mat4 directionalShadowMatrix[ NUM_DIR_LIGHT_SHADOWS ];
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		uniform mat4 pointShadowMatrix[ NUM_POINT_LIGHT_SHADOWS ];
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
#endif`,dI=`#if ( defined( USE_SHADOWMAP ) && ( NUM_DIR_LIGHT_SHADOWS > 0 || NUM_SUN_LIGHT_SHADOWS > 0 || NUM_POINT_LIGHT_SHADOWS > 0 ) ) || ( NUM_SPOT_LIGHT_COORDS > 0 )
	#ifdef HAS_NORMAL
		vec3 shadowWorldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
	#else
		vec3 shadowWorldNormal = vec3( 0.0 );
	#endif
	vec4 shadowWorldPosition;
#endif
#if defined( USE_SHADOWMAP )
	#if NUM_SUN_LIGHT_SHADOWS > 0
		vSunShadowWorldPosition = vec4( worldPosition.xyz, - mvPosition.z );
		vSunShadowWorldNormal = shadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * directionalLightShadows[ i ].shadowNormalBias, 0 );
			vDirectionalShadowCoord[ i ] = directionalShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * pointLightShadows[ i ].shadowNormalBias, 0 );
			vPointShadowCoord[ i ] = pointShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
#endif
#if NUM_SPOT_LIGHT_COORDS > 0
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_COORDS; i ++ ) {
		shadowWorldPosition = worldPosition;
		#if ( defined( USE_SHADOWMAP ) && UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
			shadowWorldPosition.xyz += shadowWorldNormal * spotLightShadows[ i ].shadowNormalBias;
		#endif
		vSpotLightCoord[ i ] = spotLightMatrix[ i ] * shadowWorldPosition;
	}
	#pragma unroll_loop_end
#endif`,pI=`float getShadowMask() {
	float shadow = 1.0;
	#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHT_SHADOWS; i ++ ) {
		sunLight = sunLightShadows[ i ];
		shadow *= receiveShadow ? getSunShadow( sunShadowMap[ i ], sunLight, UNROLLED_LOOP_INDEX ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
		directionalLight = directionalLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( directionalShadowMap[ i ], directionalLight.shadowMapSize, directionalLight.shadowIntensity, directionalLight.shadowBias, directionalLight.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_SHADOWS; i ++ ) {
		spotLight = spotLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( spotShadowMap[ i ], spotLight.shadowMapSize, spotLight.shadowIntensity, spotLight.shadowBias, spotLight.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0 && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
	PointLightShadow pointLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
		pointLight = pointLightShadows[ i ];
		shadow *= receiveShadow ? getPointShadow( pointShadowMap[ i ], pointLight.shadowMapSize, pointLight.shadowIntensity, pointLight.shadowBias, pointLight.shadowRadius, vPointShadowCoord[ i ], pointLight.shadowCameraNear, pointLight.shadowCameraFar ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#endif
	return shadow;
}`,mI=`#ifdef USE_SKINNING
	mat4 boneMatX = getBoneMatrix( skinIndex.x );
	mat4 boneMatY = getBoneMatrix( skinIndex.y );
	mat4 boneMatZ = getBoneMatrix( skinIndex.z );
	mat4 boneMatW = getBoneMatrix( skinIndex.w );
#endif`,gI=`#ifdef USE_SKINNING
	uniform mat4 bindMatrix;
	uniform mat4 bindMatrixInverse;
	uniform highp sampler2D boneTexture;
	mat4 getBoneMatrix( const in float i ) {
		int size = textureSize( boneTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( boneTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( boneTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( boneTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( boneTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
#endif`,yI=`#ifdef USE_SKINNING
	vec4 skinVertex = bindMatrix * vec4( transformed, 1.0 );
	vec4 skinned = vec4( 0.0 );
	skinned += boneMatX * skinVertex * skinWeight.x;
	skinned += boneMatY * skinVertex * skinWeight.y;
	skinned += boneMatZ * skinVertex * skinWeight.z;
	skinned += boneMatW * skinVertex * skinWeight.w;
	transformed = ( bindMatrixInverse * skinned ).xyz;
#endif`,xI=`#ifdef USE_SKINNING
	mat4 skinMatrix = mat4( 0.0 );
	skinMatrix += skinWeight.x * boneMatX;
	skinMatrix += skinWeight.y * boneMatY;
	skinMatrix += skinWeight.z * boneMatZ;
	skinMatrix += skinWeight.w * boneMatW;
	skinMatrix = bindMatrixInverse * skinMatrix * bindMatrix;
	objectNormal = vec4( skinMatrix * vec4( objectNormal, 0.0 ) ).xyz;
	#ifdef USE_TANGENT
		objectTangent = vec4( skinMatrix * vec4( objectTangent, 0.0 ) ).xyz;
	#endif
#endif`,_I=`float specularStrength;
#ifdef USE_SPECULARMAP
	vec4 texelSpecular = texture2D( specularMap, vSpecularMapUv );
	specularStrength = texelSpecular.r;
#else
	specularStrength = 1.0;
#endif`,vI=`#ifdef USE_SPECULARMAP
	uniform sampler2D specularMap;
#endif`,bI=`#if defined( TONE_MAPPING )
	gl_FragColor.rgb = toneMapping( gl_FragColor.rgb );
#endif`,MI=`#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
uniform float toneMappingExposure;
vec3 LinearToneMapping( vec3 color ) {
	return saturate( toneMappingExposure * color );
}
vec3 ReinhardToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	return saturate( color / ( vec3( 1.0 ) + color ) );
}
vec3 CineonToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	color = max( vec3( 0.0 ), color - 0.004 );
	return pow( ( color * ( 6.2 * color + 0.5 ) ) / ( color * ( 6.2 * color + 1.7 ) + 0.06 ), vec3( 2.2 ) );
}
vec3 RRTAndODTFit( vec3 v ) {
	vec3 a = v * ( v + 0.0245786 ) - 0.000090537;
	vec3 b = v * ( 0.983729 * v + 0.4329510 ) + 0.238081;
	return a / b;
}
vec3 ACESFilmicToneMapping( vec3 color ) {
	const mat3 ACESInputMat = mat3(
		vec3( 0.59719, 0.07600, 0.02840 ),		vec3( 0.35458, 0.90834, 0.13383 ),
		vec3( 0.04823, 0.01566, 0.83777 )
	);
	const mat3 ACESOutputMat = mat3(
		vec3(  1.60475, -0.10208, -0.00327 ),		vec3( -0.53108,  1.10813, -0.07276 ),
		vec3( -0.07367, -0.00605,  1.07602 )
	);
	color *= toneMappingExposure / 0.6;
	color = ACESInputMat * color;
	color = RRTAndODTFit( color );
	color = ACESOutputMat * color;
	return saturate( color );
}
const mat3 LINEAR_REC2020_TO_LINEAR_SRGB = mat3(
	vec3( 1.6605, - 0.1246, - 0.0182 ),
	vec3( - 0.5876, 1.1329, - 0.1006 ),
	vec3( - 0.0728, - 0.0083, 1.1187 )
);
const mat3 LINEAR_SRGB_TO_LINEAR_REC2020 = mat3(
	vec3( 0.6274, 0.0691, 0.0164 ),
	vec3( 0.3293, 0.9195, 0.0880 ),
	vec3( 0.0433, 0.0113, 0.8956 )
);
vec3 agxDefaultContrastApprox( vec3 x ) {
	vec3 x2 = x * x;
	vec3 x4 = x2 * x2;
	return + 15.5 * x4 * x2
		- 40.14 * x4 * x
		+ 31.96 * x4
		- 6.868 * x2 * x
		+ 0.4298 * x2
		+ 0.1191 * x
		- 0.00232;
}
vec3 AgXToneMapping( vec3 color ) {
	const mat3 AgXInsetMatrix = mat3(
		vec3( 0.856627153315983, 0.137318972929847, 0.11189821299995 ),
		vec3( 0.0951212405381588, 0.761241990602591, 0.0767994186031903 ),
		vec3( 0.0482516061458583, 0.101439036467562, 0.811302368396859 )
	);
	const mat3 AgXOutsetMatrix = mat3(
		vec3( 1.1271005818144368, - 0.1413297634984383, - 0.14132976349843826 ),
		vec3( - 0.11060664309660323, 1.157823702216272, - 0.11060664309660294 ),
		vec3( - 0.016493938717834573, - 0.016493938717834257, 1.2519364065950405 )
	);
	const float AgxMinEv = - 12.47393;	const float AgxMaxEv = 4.026069;
	color *= toneMappingExposure;
	color = LINEAR_SRGB_TO_LINEAR_REC2020 * color;
	color = AgXInsetMatrix * color;
	color = max( color, 1e-10 );	color = log2( color );
	color = ( color - AgxMinEv ) / ( AgxMaxEv - AgxMinEv );
	color = clamp( color, 0.0, 1.0 );
	color = agxDefaultContrastApprox( color );
	color = AgXOutsetMatrix * color;
	color = pow( max( vec3( 0.0 ), color ), vec3( 2.2 ) );
	color = LINEAR_REC2020_TO_LINEAR_SRGB * color;
	color = clamp( color, 0.0, 1.0 );
	return color;
}
vec3 NeutralToneMapping( vec3 color ) {
	const float StartCompression = 0.8 - 0.04;
	const float Desaturation = 0.15;
	color *= toneMappingExposure;
	float x = min( color.r, min( color.g, color.b ) );
	float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
	color -= offset;
	float peak = max( color.r, max( color.g, color.b ) );
	if ( peak < StartCompression ) return color;
	float d = 1. - StartCompression;
	float newPeak = 1. - d * d / ( peak + d - StartCompression );
	color *= newPeak / peak;
	float g = 1. - 1. / ( Desaturation * ( peak - newPeak ) + 1. );
	return mix( color, vec3( newPeak ), g );
}
vec3 CustomToneMapping( vec3 color ) { return color; }`,SI=`#ifdef USE_TRANSMISSION
	material.transmission = transmission;
	material.transmissionAlpha = 1.0;
	material.thickness = thickness;
	material.attenuationDistance = attenuationDistance;
	material.attenuationColor = attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		material.transmission *= texture2D( transmissionMap, vTransmissionMapUv ).r;
	#endif
	#ifdef USE_THICKNESSMAP
		material.thickness *= texture2D( thicknessMap, vThicknessMapUv ).g;
	#endif
	vec3 pos = vWorldPosition;
	vec3 v = normalize( cameraPosition - pos );
	vec3 n = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec4 transmitted = getIBLVolumeRefraction(
		n, v, material.roughness, material.diffuseContribution, material.specularColorBlended, material.specularF90,
		pos, modelMatrix, viewMatrix, projectionMatrix, material.dispersion, material.ior, material.thickness,
		material.attenuationColor, material.attenuationDistance );
	material.transmissionAlpha = mix( material.transmissionAlpha, transmitted.a, material.transmission );
	totalDiffuse = mix( totalDiffuse, transmitted.rgb, material.transmission );
#endif`,wI=`#ifdef USE_TRANSMISSION
	uniform float transmission;
	uniform float thickness;
	uniform float attenuationDistance;
	uniform vec3 attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		uniform sampler2D transmissionMap;
	#endif
	#ifdef USE_THICKNESSMAP
		uniform sampler2D thicknessMap;
	#endif
	uniform vec2 transmissionSamplerSize;
	uniform sampler2D transmissionSamplerMap;
	uniform mat4 modelMatrix;
	uniform mat4 projectionMatrix;
	varying vec3 vWorldPosition;
	float w0( float a ) {
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - a + 3.0 ) - 3.0 ) + 1.0 );
	}
	float w1( float a ) {
		return ( 1.0 / 6.0 ) * ( a *  a * ( 3.0 * a - 6.0 ) + 4.0 );
	}
	float w2( float a ){
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - 3.0 * a + 3.0 ) + 3.0 ) + 1.0 );
	}
	float w3( float a ) {
		return ( 1.0 / 6.0 ) * ( a * a * a );
	}
	float g0( float a ) {
		return w0( a ) + w1( a );
	}
	float g1( float a ) {
		return w2( a ) + w3( a );
	}
	float h0( float a ) {
		return - 1.0 + w1( a ) / ( w0( a ) + w1( a ) );
	}
	float h1( float a ) {
		return 1.0 + w3( a ) / ( w2( a ) + w3( a ) );
	}
	vec4 bicubic( sampler2D tex, vec2 uv, vec4 texelSize, float lod ) {
		uv = uv * texelSize.zw + 0.5;
		vec2 iuv = floor( uv );
		vec2 fuv = fract( uv );
		float g0x = g0( fuv.x );
		float g1x = g1( fuv.x );
		float h0x = h0( fuv.x );
		float h1x = h1( fuv.x );
		float h0y = h0( fuv.y );
		float h1y = h1( fuv.y );
		vec2 p0 = ( vec2( iuv.x + h0x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p1 = ( vec2( iuv.x + h1x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p2 = ( vec2( iuv.x + h0x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		vec2 p3 = ( vec2( iuv.x + h1x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		return g0( fuv.y ) * ( g0x * textureLod( tex, p0, lod ) + g1x * textureLod( tex, p1, lod ) ) +
			g1( fuv.y ) * ( g0x * textureLod( tex, p2, lod ) + g1x * textureLod( tex, p3, lod ) );
	}
	vec4 textureBicubic( sampler2D sampler, vec2 uv, float lod ) {
		vec2 fLodSize = vec2( textureSize( sampler, int( lod ) ) );
		vec2 cLodSize = vec2( textureSize( sampler, int( lod + 1.0 ) ) );
		vec2 fLodSizeInv = 1.0 / fLodSize;
		vec2 cLodSizeInv = 1.0 / cLodSize;
		vec4 fSample = bicubic( sampler, uv, vec4( fLodSizeInv, fLodSize ), floor( lod ) );
		vec4 cSample = bicubic( sampler, uv, vec4( cLodSizeInv, cLodSize ), ceil( lod ) );
		return mix( fSample, cSample, fract( lod ) );
	}
	vec3 getVolumeTransmissionRay( const in vec3 n, const in vec3 v, const in float thickness, const in float ior, const in mat4 modelMatrix ) {
		vec3 refractionVector = refract( - v, normalize( n ), 1.0 / ior );
		vec3 modelScale;
		modelScale.x = length( vec3( modelMatrix[ 0 ].xyz ) );
		modelScale.y = length( vec3( modelMatrix[ 1 ].xyz ) );
		modelScale.z = length( vec3( modelMatrix[ 2 ].xyz ) );
		return normalize( refractionVector ) * thickness * modelScale;
	}
	float applyIorToRoughness( const in float roughness, const in float ior ) {
		return roughness * clamp( ior * 2.0 - 2.0, 0.0, 1.0 );
	}
	vec4 getTransmissionSample( const in vec2 fragCoord, const in float roughness, const in float ior ) {
		float lod = log2( transmissionSamplerSize.x ) * applyIorToRoughness( roughness, ior );
		return textureBicubic( transmissionSamplerMap, fragCoord.xy, lod );
	}
	vec3 volumeAttenuation( const in float transmissionDistance, const in vec3 attenuationColor, const in float attenuationDistance ) {
		if ( isinf( attenuationDistance ) ) {
			return vec3( 1.0 );
		} else {
			vec3 attenuationCoefficient = -log( attenuationColor ) / attenuationDistance;
			vec3 transmittance = exp( - attenuationCoefficient * transmissionDistance );			return transmittance;
		}
	}
	vec4 getIBLVolumeRefraction( const in vec3 n, const in vec3 v, const in float roughness, const in vec3 diffuseColor,
		const in vec3 specularColor, const in float specularF90, const in vec3 position, const in mat4 modelMatrix,
		const in mat4 viewMatrix, const in mat4 projMatrix, const in float dispersion, const in float ior, const in float thickness,
		const in vec3 attenuationColor, const in float attenuationDistance ) {
		vec4 transmittedLight;
		vec3 transmittance;
		#ifdef USE_DISPERSION
			float halfSpread = ( ior - 1.0 ) * 0.025 * dispersion;
			vec3 iors = vec3( ior - halfSpread, ior, ior + halfSpread );
			for ( int i = 0; i < 3; i ++ ) {
				vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, iors[ i ], modelMatrix );
				vec3 refractedRayExit = position + transmissionRay;
				vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
				vec2 refractionCoords = ndcPos.xy / ndcPos.w;
				refractionCoords += 1.0;
				refractionCoords /= 2.0;
				vec4 transmissionSample = getTransmissionSample( refractionCoords, roughness, iors[ i ] );
				transmittedLight[ i ] = transmissionSample[ i ];
				transmittedLight.a += transmissionSample.a;
				transmittance[ i ] = diffuseColor[ i ] * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance )[ i ];
			}
			transmittedLight.a /= 3.0;
		#else
			vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, ior, modelMatrix );
			vec3 refractedRayExit = position + transmissionRay;
			vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
			vec2 refractionCoords = ndcPos.xy / ndcPos.w;
			refractionCoords += 1.0;
			refractionCoords /= 2.0;
			transmittedLight = getTransmissionSample( refractionCoords, roughness, ior );
			transmittance = diffuseColor * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance );
		#endif
		vec3 attenuatedColor = transmittance * transmittedLight.rgb;
		vec3 F = EnvironmentBRDF( n, v, specularColor, specularF90, roughness );
		float transmittanceFactor = ( transmittance.r + transmittance.g + transmittance.b ) / 3.0;
		return vec4( ( 1.0 - F ) * attenuatedColor, 1.0 - ( 1.0 - transmittedLight.a ) * transmittanceFactor );
	}
#endif`,TI=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_SPECULARMAP
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,AI=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	uniform mat3 mapTransform;
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	uniform mat3 alphaMapTransform;
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	uniform mat3 lightMapTransform;
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	uniform mat3 aoMapTransform;
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	uniform mat3 bumpMapTransform;
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	uniform mat3 normalMapTransform;
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_DISPLACEMENTMAP
	uniform mat3 displacementMapTransform;
	varying vec2 vDisplacementMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	uniform mat3 emissiveMapTransform;
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	uniform mat3 metalnessMapTransform;
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	uniform mat3 roughnessMapTransform;
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	uniform mat3 diffuseRoughnessMapTransform;
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	uniform mat3 anisotropyMapTransform;
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	uniform mat3 clearcoatMapTransform;
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform mat3 clearcoatNormalMapTransform;
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform mat3 clearcoatRoughnessMapTransform;
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	uniform mat3 sheenColorMapTransform;
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	uniform mat3 sheenRoughnessMapTransform;
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	uniform mat3 iridescenceMapTransform;
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform mat3 iridescenceThicknessMapTransform;
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SPECULARMAP
	uniform mat3 specularMapTransform;
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	uniform mat3 specularColorMapTransform;
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	uniform mat3 specularIntensityMapTransform;
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,EI=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	vUv = vec3( uv, 1 ).xy;
#endif
#ifdef USE_MAP
	vMapUv = ( mapTransform * vec3( MAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ALPHAMAP
	vAlphaMapUv = ( alphaMapTransform * vec3( ALPHAMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_LIGHTMAP
	vLightMapUv = ( lightMapTransform * vec3( LIGHTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_AOMAP
	vAoMapUv = ( aoMapTransform * vec3( AOMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_BUMPMAP
	vBumpMapUv = ( bumpMapTransform * vec3( BUMPMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_NORMALMAP
	vNormalMapUv = ( normalMapTransform * vec3( NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DISPLACEMENTMAP
	vDisplacementMapUv = ( displacementMapTransform * vec3( DISPLACEMENTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_EMISSIVEMAP
	vEmissiveMapUv = ( emissiveMapTransform * vec3( EMISSIVEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_METALNESSMAP
	vMetalnessMapUv = ( metalnessMapTransform * vec3( METALNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ROUGHNESSMAP
	vRoughnessMapUv = ( roughnessMapTransform * vec3( ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	vDiffuseRoughnessMapUv = ( diffuseRoughnessMapTransform * vec3( DIFFUSE_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ANISOTROPYMAP
	vAnisotropyMapUv = ( anisotropyMapTransform * vec3( ANISOTROPYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOATMAP
	vClearcoatMapUv = ( clearcoatMapTransform * vec3( CLEARCOATMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	vClearcoatNormalMapUv = ( clearcoatNormalMapTransform * vec3( CLEARCOAT_NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	vClearcoatRoughnessMapUv = ( clearcoatRoughnessMapTransform * vec3( CLEARCOAT_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCEMAP
	vIridescenceMapUv = ( iridescenceMapTransform * vec3( IRIDESCENCEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	vIridescenceThicknessMapUv = ( iridescenceThicknessMapTransform * vec3( IRIDESCENCE_THICKNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_COLORMAP
	vSheenColorMapUv = ( sheenColorMapTransform * vec3( SHEEN_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	vSheenRoughnessMapUv = ( sheenRoughnessMapTransform * vec3( SHEEN_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULARMAP
	vSpecularMapUv = ( specularMapTransform * vec3( SPECULARMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_COLORMAP
	vSpecularColorMapUv = ( specularColorMapTransform * vec3( SPECULAR_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	vSpecularIntensityMapUv = ( specularIntensityMapTransform * vec3( SPECULAR_INTENSITYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_TRANSMISSIONMAP
	vTransmissionMapUv = ( transmissionMapTransform * vec3( TRANSMISSIONMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_THICKNESSMAP
	vThicknessMapUv = ( thicknessMapTransform * vec3( THICKNESSMAP_UV, 1 ) ).xy;
#endif`,CI=`#if defined( USE_ENVMAP ) || defined( DISTANCE ) || defined ( USE_SHADOWMAP ) || defined ( USE_TRANSMISSION ) || NUM_SPOT_LIGHT_COORDS > 0
	vec4 worldPosition = vec4( transformed, 1.0 );
	#ifdef USE_BATCHING
		worldPosition = batchingMatrix * worldPosition;
	#endif
	#ifdef USE_INSTANCING
		worldPosition = instanceMatrix * worldPosition;
	#endif
	worldPosition = modelMatrix * worldPosition;
#endif`,RI=`varying vec2 vUv;
uniform mat3 uvTransform;
void main() {
	vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	gl_Position = vec4( position.xy, 1.0, 1.0 );
}`,II=`uniform sampler2D t2D;
uniform float backgroundIntensity;
varying vec2 vUv;
void main() {
	vec4 texColor = texture2D( t2D, vUv );
	#ifdef DECODE_VIDEO_TEXTURE
		texColor = vec4( mix( pow( texColor.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), texColor.rgb * 0.0773993808, vec3( lessThanEqual( texColor.rgb, vec3( 0.04045 ) ) ) ), texColor.w );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,PI=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,LI=`uniform float backgroundBlurriness;
uniform float backgroundIntensity;
uniform mat3 backgroundRotation;
varying vec3 vWorldDirection;
#include <envmap_common_pars_fragment>
void main() {
	#ifdef ENVMAP_TYPE_PMREM
		vec4 texColor = textureLod( envMap, backgroundRotation * vWorldDirection, roughnessToMip( backgroundBlurriness ) );
	#else
		vec4 texColor = textureCube( envMap, backgroundRotation * vWorldDirection );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,NI=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,DI=`uniform samplerCube tCube;
uniform float tFlip;
uniform float opacity;
varying vec3 vWorldDirection;
void main() {
	vec4 texColor = textureCube( tCube, vec3( tFlip * vWorldDirection.x, vWorldDirection.yz ) );
	gl_FragColor = texColor;
	gl_FragColor.a *= opacity;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,FI=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
varying vec2 vHighPrecisionZW;
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vHighPrecisionZW = gl_Position.zw;
}`,UI=`#if DEPTH_PACKING == 3200
	uniform float opacity;
#endif
#include <common>
#include <packing>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
varying vec2 vHighPrecisionZW;
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#if DEPTH_PACKING == 3200
		diffuseColor.a = opacity;
	#endif
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <logdepthbuf_fragment>
	#ifdef USE_REVERSED_DEPTH_BUFFER
		float fragCoordZ = vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ];
	#else
		float fragCoordZ = 0.5 * vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ] + 0.5;
	#endif
	#if DEPTH_PACKING == 3200
		gl_FragColor = vec4( vec3( 1.0 - fragCoordZ ), opacity );
	#elif DEPTH_PACKING == 3201
		gl_FragColor = packDepthToRGBA( fragCoordZ );
	#elif DEPTH_PACKING == 3202
		gl_FragColor = vec4( packDepthToRGB( fragCoordZ ), 1.0 );
	#elif DEPTH_PACKING == 3203
		gl_FragColor = vec4( packDepthToRG( fragCoordZ ), 0.0, 1.0 );
	#endif
}`,OI=`#define DISTANCE
varying vec3 vWorldPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <worldpos_vertex>
	#include <clipping_planes_vertex>
	vWorldPosition = worldPosition.xyz;
}`,BI=`#define DISTANCE
uniform vec3 referencePosition;
uniform float nearDistance;
uniform float farDistance;
varying vec3 vWorldPosition;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	float dist = length( vWorldPosition - referencePosition );
	dist = ( dist - nearDistance ) / ( farDistance - nearDistance );
	dist = saturate( dist );
	gl_FragColor = vec4( dist, 0.0, 0.0, 1.0 );
}`,kI=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
}`,zI=`uniform sampler2D tEquirect;
varying vec3 vWorldDirection;
#include <common>
void main() {
	vec3 direction = normalize( vWorldDirection );
	vec2 sampleUV = equirectUv( direction );
	gl_FragColor = texture2D( tEquirect, sampleUV );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,GI=`uniform float scale;
attribute float lineDistance;
varying float vLineDistance;
#include <common>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	vLineDistance = scale * lineDistance;
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,VI=`uniform vec3 diffuse;
uniform float opacity;
uniform float dashSize;
uniform float totalSize;
varying float vLineDistance;
#include <common>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	if ( mod( vLineDistance, totalSize ) > dashSize ) {
		discard;
	}
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,HI=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#if defined ( USE_ENVMAP ) || defined ( USE_SKINNING )
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinbase_vertex>
		#include <skinnormal_vertex>
		#include <defaultnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <fog_vertex>
}`,WI=`uniform vec3 diffuse;
uniform float opacity;
#ifndef FLAT_SHADED
	varying vec3 vNormal;
#endif
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <fog_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		reflectedLight.indirectDiffuse += lightMapTexel.rgb * lightMapIntensity * RECIPROCAL_PI;
	#else
		reflectedLight.indirectDiffuse += vec3( 1.0 );
	#endif
	#include <aomap_fragment>
	reflectedLight.indirectDiffuse *= diffuseColor.rgb;
	vec3 outgoingLight = reflectedLight.indirectDiffuse;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,$I=`#define LAMBERT
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,XI=`#define LAMBERT
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_lambert_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_lambert_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,qI=`#define MATCAP
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <displacementmap_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
	vViewPosition = - mvPosition.xyz;
}`,YI=`#define MATCAP
uniform vec3 diffuse;
uniform float opacity;
uniform sampler2D matcap;
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	vec3 viewDir = normalize( vViewPosition );
	vec3 x = normalize( vec3( viewDir.z, 0.0, - viewDir.x ) );
	vec3 y = cross( viewDir, x );
	vec2 uv = vec2( dot( x, normal ), dot( y, normal ) ) * 0.495 + 0.5;
	#ifdef USE_MATCAP
		vec4 matcapColor = texture2D( matcap, uv );
	#else
		vec4 matcapColor = vec4( vec3( mix( 0.2, 0.8, uv.y ) ), 1.0 );
	#endif
	vec3 outgoingLight = diffuseColor.rgb * matcapColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,ZI=`#define NORMAL
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	vViewPosition = - mvPosition.xyz;
#endif
}`,JI=`#define NORMAL
uniform float opacity;
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <uv_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 0.0, 0.0, 0.0, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	gl_FragColor = vec4( normalize( normal ) * 0.5 + 0.5, diffuseColor.a );
	#ifdef OPAQUE
		gl_FragColor.a = 1.0;
	#endif
}`,KI=`#define PHONG
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,jI=`#define PHONG
uniform vec3 diffuse;
uniform vec3 emissive;
uniform vec3 specular;
uniform float shininess;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_phong_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_phong_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + reflectedLight.directSpecular + reflectedLight.indirectSpecular + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,QI=`#define STANDARD
varying vec3 vViewPosition;
#ifdef USE_TRANSMISSION
	varying vec3 vWorldPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
#ifdef USE_TRANSMISSION
	vWorldPosition = worldPosition.xyz;
#endif
}`,tP=`#define STANDARD
#ifdef PHYSICAL
	#define IOR
	#define USE_SPECULAR
#endif
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float roughness;
uniform float metalness;
uniform float opacity;
#ifdef IOR
	uniform float ior;
#endif
#ifdef USE_SPECULAR
	uniform float specularIntensity;
	uniform vec3 specularColor;
	#ifdef USE_SPECULAR_COLORMAP
		uniform sampler2D specularColorMap;
	#endif
	#ifdef USE_SPECULAR_INTENSITYMAP
		uniform sampler2D specularIntensityMap;
	#endif
#endif
#ifdef USE_CLEARCOAT
	uniform float clearcoat;
	uniform float clearcoatRoughness;
#endif
#ifdef USE_DIFFUSE_ROUGHNESS
	uniform float diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		uniform sampler2D diffuseRoughnessMap;
	#endif
#endif
#ifdef USE_DISPERSION
	uniform float dispersion;
#endif
#ifdef USE_RETROREFLECTION
	uniform float retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	uniform float iridescence;
	uniform float iridescenceIOR;
	uniform float iridescenceThicknessMinimum;
	uniform float iridescenceThicknessMaximum;
#endif
#ifdef USE_SHEEN
	uniform vec3 sheenColor;
	uniform float sheenRoughness;
	#ifdef USE_SHEEN_COLORMAP
		uniform sampler2D sheenColorMap;
	#endif
	#ifdef USE_SHEEN_ROUGHNESSMAP
		uniform sampler2D sheenRoughnessMap;
	#endif
#endif
#ifdef USE_ANISOTROPY
	uniform vec2 anisotropyVector;
	#ifdef USE_ANISOTROPYMAP
		uniform sampler2D anisotropyMap;
	#endif
#endif
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <iridescence_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_physical_pars_fragment>
#include <transmission_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <clearcoat_pars_fragment>
#include <iridescence_pars_fragment>
#include <roughnessmap_pars_fragment>
#include <metalnessmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <roughnessmap_fragment>
	#include <metalnessmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <clearcoat_normal_fragment_begin>
	#include <clearcoat_normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_physical_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 totalDiffuse = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
	vec3 totalSpecular = reflectedLight.directSpecular + reflectedLight.indirectSpecular;
	#include <transmission_fragment>
	vec3 outgoingLight = totalDiffuse + totalSpecular + totalEmissiveRadiance;
	#ifdef USE_SHEEN
 
		outgoingLight = outgoingLight + sheenSpecularDirect + sheenSpecularIndirect;
 
 	#endif
	#ifdef USE_CLEARCOAT
		float dotNVcc = saturate( dot( geometryClearcoatNormal, geometryViewDir ) );
		vec3 Fcc = F_Schlick( material.clearcoatF0, material.clearcoatF90, dotNVcc );
		outgoingLight = outgoingLight * ( 1.0 - material.clearcoat * Fcc ) + ( clearcoatSpecularDirect + clearcoatSpecularIndirect ) * material.clearcoat;
	#endif
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,eP=`#define TOON
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,nP=`#define TOON
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <gradientmap_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_toon_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_toon_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,iP=`uniform float size;
uniform float scale;
#include <common>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
#ifdef USE_POINTS_UV
	varying vec2 vUv;
	uniform mat3 uvTransform;
#endif
void main() {
	#ifdef USE_POINTS_UV
		vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	#endif
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	gl_PointSize = size;
	#ifdef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) gl_PointSize *= ( scale / - mvPosition.z );
	#endif
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <fog_vertex>
}`,rP=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <color_pars_fragment>
#include <map_particle_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_particle_fragment>
	#include <color_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,sP=`#include <common>
#include <batching_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <shadowmap_pars_vertex>
void main() {
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,oP=`uniform vec3 color;
uniform float opacity;
#include <common>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <logdepthbuf_pars_fragment>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
void main() {
	#include <logdepthbuf_fragment>
	gl_FragColor = vec4( color, opacity * ( 1.0 - getShadowMask() ) );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,aP=`uniform float rotation;
uniform vec2 center;
#include <common>
#include <uv_pars_vertex>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	vec4 mvPosition = modelViewMatrix[ 3 ];
	vec2 scale = vec2( length( modelMatrix[ 0 ].xyz ), length( modelMatrix[ 1 ].xyz ) );
	#ifndef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) scale *= - mvPosition.z;
	#endif
	vec2 alignedPosition = ( position.xy - ( center - vec2( 0.5 ) ) ) * scale;
	vec2 rotatedPosition;
	rotatedPosition.x = cos( rotation ) * alignedPosition.x - sin( rotation ) * alignedPosition.y;
	rotatedPosition.y = sin( rotation ) * alignedPosition.x + cos( rotation ) * alignedPosition.y;
	mvPosition.xy += rotatedPosition;
	gl_Position = projectionMatrix * mvPosition;
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,cP=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
}`,Jt={alphahash_fragment:IC,alphahash_pars_fragment:PC,alphamap_fragment:LC,alphamap_pars_fragment:NC,alphatest_fragment:DC,alphatest_pars_fragment:FC,aomap_fragment:UC,aomap_pars_fragment:OC,batching_pars_vertex:BC,batching_vertex:kC,begin_vertex:zC,beginnormal_vertex:GC,bsdfs:VC,iridescence_fragment:HC,bumpmap_pars_fragment:WC,clipping_planes_fragment:$C,clipping_planes_pars_fragment:XC,clipping_planes_pars_vertex:qC,clipping_planes_vertex:YC,color_fragment:ZC,color_pars_fragment:JC,color_pars_vertex:KC,color_vertex:jC,common:QC,defaultnormal_vertex:tR,displacementmap_pars_vertex:eR,displacementmap_vertex:nR,emissivemap_fragment:iR,emissivemap_pars_fragment:rR,colorspace_fragment:sR,colorspace_pars_fragment:oR,envmap_fragment:aR,envmap_common_pars_fragment:cR,envmap_pars_fragment:lR,envmap_pars_vertex:uR,envmap_physical_pars_fragment:bR,envmap_vertex:fR,fog_vertex:hR,fog_pars_vertex:dR,fog_fragment:pR,fog_pars_fragment:mR,gradientmap_pars_fragment:gR,lightmap_pars_fragment:yR,lights_lambert_fragment:xR,lights_lambert_pars_fragment:_R,lights_pars_begin:vR,lights_toon_fragment:MR,lights_toon_pars_fragment:SR,lights_phong_fragment:wR,lights_phong_pars_fragment:TR,lights_physical_fragment:AR,lights_physical_pars_fragment:ER,lights_fragment_begin:CR,lights_fragment_maps:RR,lights_fragment_end:IR,lightprobes_pars_fragment:PR,logdepthbuf_fragment:LR,logdepthbuf_pars_fragment:NR,logdepthbuf_pars_vertex:DR,logdepthbuf_vertex:FR,map_fragment:UR,map_pars_fragment:OR,map_particle_fragment:BR,map_particle_pars_fragment:kR,metalnessmap_fragment:zR,metalnessmap_pars_fragment:GR,morphinstance_vertex:VR,morphcolor_vertex:HR,morphnormal_vertex:WR,morphtarget_pars_vertex:$R,morphtarget_vertex:XR,normal_fragment_begin:qR,normal_fragment_maps:YR,normal_pars_fragment:ZR,normal_pars_vertex:JR,normal_vertex:KR,normalmap_pars_fragment:jR,clearcoat_normal_fragment_begin:QR,clearcoat_normal_fragment_maps:tI,clearcoat_pars_fragment:eI,iridescence_pars_fragment:nI,opaque_fragment:iI,packing:rI,premultiplied_alpha_fragment:sI,project_vertex:oI,dithering_fragment:aI,dithering_pars_fragment:cI,roughnessmap_fragment:lI,roughnessmap_pars_fragment:uI,shadowmap_pars_fragment:fI,shadowmap_pars_vertex:hI,shadowmap_vertex:dI,shadowmask_pars_fragment:pI,skinbase_vertex:mI,skinning_pars_vertex:gI,skinning_vertex:yI,skinnormal_vertex:xI,specularmap_fragment:_I,specularmap_pars_fragment:vI,tonemapping_fragment:bI,tonemapping_pars_fragment:MI,transmission_fragment:SI,transmission_pars_fragment:wI,uv_pars_fragment:TI,uv_pars_vertex:AI,uv_vertex:EI,worldpos_vertex:CI,background_vert:RI,background_frag:II,backgroundCube_vert:PI,backgroundCube_frag:LI,cube_vert:NI,cube_frag:DI,depth_vert:FI,depth_frag:UI,distance_vert:OI,distance_frag:BI,equirect_vert:kI,equirect_frag:zI,linedashed_vert:GI,linedashed_frag:VI,meshbasic_vert:HI,meshbasic_frag:WI,meshlambert_vert:$I,meshlambert_frag:XI,meshmatcap_vert:qI,meshmatcap_frag:YI,meshnormal_vert:ZI,meshnormal_frag:JI,meshphong_vert:KI,meshphong_frag:jI,meshphysical_vert:QI,meshphysical_frag:tP,meshtoon_vert:eP,meshtoon_frag:nP,points_vert:iP,points_frag:rP,shadow_vert:sP,shadow_frag:oP,sprite_vert:aP,sprite_frag:cP},Tt={common:{diffuse:{value:new Zt(16777215)},opacity:{value:1},map:{value:null},mapTransform:{value:new zt},alphaMap:{value:null},alphaMapTransform:{value:new zt},alphaTest:{value:0}},specularmap:{specularMap:{value:null},specularMapTransform:{value:new zt}},envmap:{envMap:{value:null},envMapRotation:{value:new zt},reflectivity:{value:1},ior:{value:1.5},refractionRatio:{value:.98},dfgLUT:{value:null}},aomap:{aoMap:{value:null},aoMapIntensity:{value:1},aoMapTransform:{value:new zt}},lightmap:{lightMap:{value:null},lightMapIntensity:{value:1},lightMapTransform:{value:new zt}},bumpmap:{bumpMap:{value:null},bumpMapTransform:{value:new zt},bumpScale:{value:1}},normalmap:{normalMap:{value:null},normalMapTransform:{value:new zt},normalScale:{value:new ie(1,1)}},displacementmap:{displacementMap:{value:null},displacementMapTransform:{value:new zt},displacementScale:{value:1},displacementBias:{value:0}},emissivemap:{emissiveMap:{value:null},emissiveMapTransform:{value:new zt}},metalnessmap:{metalnessMap:{value:null},metalnessMapTransform:{value:new zt}},roughnessmap:{roughnessMap:{value:null},roughnessMapTransform:{value:new zt}},gradientmap:{gradientMap:{value:null}},fog:{fogDensity:{value:25e-5},fogNear:{value:1},fogFar:{value:2e3},fogColor:{value:new Zt(16777215)}},lights:{ambientLightColor:{value:[]},lightProbe:{value:[]},sunLights:{value:[],properties:{direction:{},color:{}}},sunLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},sunShadowMatrix:{value:[]},sunShadowCascade:{value:[]},directionalLights:{value:[],properties:{direction:{},color:{}}},directionalLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},directionalShadowMatrix:{value:[]},spotLights:{value:[],properties:{color:{},position:{},direction:{},distance:{},coneCos:{},penumbraCos:{},decay:{}}},spotLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},spotLightMap:{value:[]},spotLightMatrix:{value:[]},pointLights:{value:[],properties:{color:{},position:{},decay:{},distance:{}}},pointLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{},shadowCameraNear:{},shadowCameraFar:{}}},pointShadowMatrix:{value:[]},hemisphereLights:{value:[],properties:{direction:{},skyColor:{},groundColor:{}}},rectAreaLights:{value:[],properties:{color:{},position:{},width:{},height:{}}},ltc_1:{value:null},ltc_2:{value:null},probesSH:{value:[]},probesMin:{value:[]},probesMax:{value:[]},probesResolution:{value:[]}},points:{diffuse:{value:new Zt(16777215)},opacity:{value:1},size:{value:1},scale:{value:1},map:{value:null},alphaMap:{value:null},alphaMapTransform:{value:new zt},alphaTest:{value:0},uvTransform:{value:new zt}},sprite:{diffuse:{value:new Zt(16777215)},opacity:{value:1},center:{value:new ie(.5,.5)},rotation:{value:0},map:{value:null},mapTransform:{value:new zt},alphaMap:{value:null},alphaMapTransform:{value:new zt},alphaTest:{value:0}}},Ji={basic:{uniforms:mn([Tt.common,Tt.specularmap,Tt.envmap,Tt.aomap,Tt.lightmap,Tt.fog]),vertexShader:Jt.meshbasic_vert,fragmentShader:Jt.meshbasic_frag},lambert:{uniforms:mn([Tt.common,Tt.specularmap,Tt.envmap,Tt.aomap,Tt.lightmap,Tt.emissivemap,Tt.bumpmap,Tt.normalmap,Tt.displacementmap,Tt.fog,Tt.lights,{emissive:{value:new Zt(0)},envMapIntensity:{value:1}}]),vertexShader:Jt.meshlambert_vert,fragmentShader:Jt.meshlambert_frag},phong:{uniforms:mn([Tt.common,Tt.specularmap,Tt.envmap,Tt.aomap,Tt.lightmap,Tt.emissivemap,Tt.bumpmap,Tt.normalmap,Tt.displacementmap,Tt.fog,Tt.lights,{emissive:{value:new Zt(0)},specular:{value:new Zt(1118481)},shininess:{value:30},envMapIntensity:{value:1}}]),vertexShader:Jt.meshphong_vert,fragmentShader:Jt.meshphong_frag},standard:{uniforms:mn([Tt.common,Tt.envmap,Tt.aomap,Tt.lightmap,Tt.emissivemap,Tt.bumpmap,Tt.normalmap,Tt.displacementmap,Tt.roughnessmap,Tt.metalnessmap,Tt.fog,Tt.lights,{emissive:{value:new Zt(0)},roughness:{value:1},metalness:{value:0},envMapIntensity:{value:1}}]),vertexShader:Jt.meshphysical_vert,fragmentShader:Jt.meshphysical_frag},toon:{uniforms:mn([Tt.common,Tt.aomap,Tt.lightmap,Tt.emissivemap,Tt.bumpmap,Tt.normalmap,Tt.displacementmap,Tt.gradientmap,Tt.fog,Tt.lights,{emissive:{value:new Zt(0)}}]),vertexShader:Jt.meshtoon_vert,fragmentShader:Jt.meshtoon_frag},matcap:{uniforms:mn([Tt.common,Tt.bumpmap,Tt.normalmap,Tt.displacementmap,Tt.fog,{matcap:{value:null}}]),vertexShader:Jt.meshmatcap_vert,fragmentShader:Jt.meshmatcap_frag},points:{uniforms:mn([Tt.points,Tt.fog]),vertexShader:Jt.points_vert,fragmentShader:Jt.points_frag},dashed:{uniforms:mn([Tt.common,Tt.fog,{scale:{value:1},dashSize:{value:1},totalSize:{value:2}}]),vertexShader:Jt.linedashed_vert,fragmentShader:Jt.linedashed_frag},depth:{uniforms:mn([Tt.common,Tt.displacementmap]),vertexShader:Jt.depth_vert,fragmentShader:Jt.depth_frag},normal:{uniforms:mn([Tt.common,Tt.bumpmap,Tt.normalmap,Tt.displacementmap,{opacity:{value:1}}]),vertexShader:Jt.meshnormal_vert,fragmentShader:Jt.meshnormal_frag},sprite:{uniforms:mn([Tt.sprite,Tt.fog]),vertexShader:Jt.sprite_vert,fragmentShader:Jt.sprite_frag},background:{uniforms:{uvTransform:{value:new zt},t2D:{value:null},backgroundIntensity:{value:1}},vertexShader:Jt.background_vert,fragmentShader:Jt.background_frag},backgroundCube:{uniforms:{envMap:{value:null},backgroundBlurriness:{value:0},backgroundIntensity:{value:1},backgroundRotation:{value:new zt}},vertexShader:Jt.backgroundCube_vert,fragmentShader:Jt.backgroundCube_frag},cube:{uniforms:{tCube:{value:null},tFlip:{value:-1},opacity:{value:1}},vertexShader:Jt.cube_vert,fragmentShader:Jt.cube_frag},equirect:{uniforms:{tEquirect:{value:null}},vertexShader:Jt.equirect_vert,fragmentShader:Jt.equirect_frag},distance:{uniforms:mn([Tt.common,Tt.displacementmap,{referencePosition:{value:new W},nearDistance:{value:1},farDistance:{value:1e3}}]),vertexShader:Jt.distance_vert,fragmentShader:Jt.distance_frag},shadow:{uniforms:mn([Tt.lights,Tt.fog,{color:{value:new Zt(0)},opacity:{value:1}}]),vertexShader:Jt.shadow_vert,fragmentShader:Jt.shadow_frag}};Ji.physical={uniforms:mn([Ji.standard.uniforms,{clearcoat:{value:0},clearcoatMap:{value:null},clearcoatMapTransform:{value:new zt},clearcoatNormalMap:{value:null},clearcoatNormalMapTransform:{value:new zt},clearcoatNormalScale:{value:new ie(1,1)},clearcoatRoughness:{value:0},clearcoatRoughnessMap:{value:null},clearcoatRoughnessMapTransform:{value:new zt},diffuseRoughness:{value:0},diffuseRoughnessMap:{value:null},diffuseRoughnessMapTransform:{value:new zt},dispersion:{value:0},retroreflectivity:{value:0},iridescence:{value:0},iridescenceMap:{value:null},iridescenceMapTransform:{value:new zt},iridescenceIOR:{value:1.3},iridescenceThicknessMinimum:{value:100},iridescenceThicknessMaximum:{value:400},iridescenceThicknessMap:{value:null},iridescenceThicknessMapTransform:{value:new zt},sheen:{value:0},sheenColor:{value:new Zt(0)},sheenColorMap:{value:null},sheenColorMapTransform:{value:new zt},sheenRoughness:{value:1},sheenRoughnessMap:{value:null},sheenRoughnessMapTransform:{value:new zt},transmission:{value:0},transmissionMap:{value:null},transmissionMapTransform:{value:new zt},transmissionSamplerSize:{value:new ie},transmissionSamplerMap:{value:null},thickness:{value:0},thicknessMap:{value:null},thicknessMapTransform:{value:new zt},attenuationDistance:{value:0},attenuationColor:{value:new Zt(0)},specularColor:{value:new Zt(1,1,1)},specularColorMap:{value:null},specularColorMapTransform:{value:new zt},specularIntensity:{value:1},specularIntensityMap:{value:null},specularIntensityMapTransform:{value:new zt},anisotropyVector:{value:new ie},anisotropyMap:{value:null},anisotropyMapTransform:{value:new zt}}]),vertexShader:Jt.meshphysical_vert,fragmentShader:Jt.meshphysical_frag};var Qf={r:0,b:0,g:0},lP=new we,Db=new zt;Db.set(-1,0,0,0,1,0,0,0,1);function uP(e,t,n,i,r,s){let o=new Zt(0),a=r===!0?0:1,c,l,u=null,h=0,f=null;function d(v){let S=v.isScene===!0?v.background:null;if(S&&S.isTexture){let _=v.backgroundBlurriness>0;S=t.get(S,_)}return S}function p(v){let S=!1,_=d(v);_===null?m(o,a):_&&_.isColor&&(m(_,1),S=!0);let w=e.xr.getEnvironmentBlendMode();w==="additive"?n.buffers.color.setClear(0,0,0,1,s):w==="alpha-blend"&&n.buffers.color.setClear(0,0,0,0,s),(e.autoClear||S)&&(n.buffers.depth.setTest(!0),n.buffers.depth.setMask(!0),n.buffers.color.setMask(!0),e.clear(e.autoClearColor,e.autoClearDepth,e.autoClearStencil))}function y(v,S){let _=d(S);_&&_.isCubeTexture?(l===void 0&&(l=new Yn(new ds(1,1,1),new qi({name:"BackgroundCubeMaterial",uniforms:Qs(Ji.backgroundCube.uniforms),vertexShader:Ji.backgroundCube.vertexShader,fragmentShader:Ji.backgroundCube.fragmentShader,side:Tn,depthTest:!1,depthWrite:!1,fog:!1,allowOverride:!1})),l.geometry.deleteAttribute("normal"),l.geometry.deleteAttribute("uv"),l.onBeforeRender=function(w,b,x){this.matrixWorld.copyPosition(x.matrixWorld)},Object.defineProperty(l.material,"envMap",{get:function(){return this.uniforms.envMap.value}}),i.update(l)),l.material.uniforms.envMap.value=_,l.material.uniforms.backgroundBlurriness.value=S.backgroundBlurriness,l.material.uniforms.backgroundIntensity.value=S.backgroundIntensity,l.material.uniforms.backgroundRotation.value.setFromMatrix4(lP.makeRotationFromEuler(S.backgroundRotation)).transpose(),_.isRenderTargetTexture===!1&&l.material.uniforms.backgroundRotation.value.premultiply(Db),l.material.toneMapped=ee.getTransfer(_.colorSpace)!==ue,(u!==_||h!==_.version||f!==e.toneMapping)&&(l.material.needsUpdate=!0,u=_,h=_.version,f=e.toneMapping),l.layers.enableAll(),v.unshift(l,l.geometry,l.material,0,0,null)):_&&_.isTexture&&(c===void 0&&(c=new Yn(new Ys(2,2),new qi({name:"BackgroundMaterial",uniforms:Qs(Ji.background.uniforms),vertexShader:Ji.background.vertexShader,fragmentShader:Ji.background.fragmentShader,side:ys,depthTest:!1,depthWrite:!1,fog:!1,allowOverride:!1})),c.geometry.deleteAttribute("normal"),Object.defineProperty(c.material,"map",{get:function(){return this.uniforms.t2D.value}}),i.update(c)),c.material.uniforms.t2D.value=_,c.material.uniforms.backgroundIntensity.value=S.backgroundIntensity,c.material.toneMapped=ee.getTransfer(_.colorSpace)!==ue,_.matrixAutoUpdate===!0&&_.updateMatrix(),c.material.uniforms.uvTransform.value.copy(_.matrix),(u!==_||h!==_.version||f!==e.toneMapping)&&(c.material.needsUpdate=!0,u=_,h=_.version,f=e.toneMapping),c.layers.enableAll(),v.unshift(c,c.geometry,c.material,0,0,null))}function m(v,S){v.getRGB(Qf,Am(e)),n.buffers.color.setClear(Qf.r,Qf.g,Qf.b,S,s)}function g(){l!==void 0&&(l.geometry.dispose(),l.material.dispose(),l=void 0),c!==void 0&&(c.geometry.dispose(),c.material.dispose(),c=void 0)}return{getClearColor:function(){return o},setClearColor:function(v,S=1){o.set(v),a=S,m(o,a)},getClearAlpha:function(){return a},setClearAlpha:function(v){a=v,m(o,a)},render:p,addToRenderList:y,dispose:g}}function fP(e,t){let n=e.getParameter(e.MAX_VERTEX_ATTRIBS),i={},r=f(null),s=r,o=!1;function a(C,N,B,I,L){let k=!1,F=h(C,I,B,N);s!==F&&(s=F,l(s.object)),k=d(C,I,B,L),k&&p(C,I,B,L),L!==null&&t.update(L,e.ELEMENT_ARRAY_BUFFER),(k||o)&&(o=!1,_(C,N,B,I),L!==null&&e.bindBuffer(e.ELEMENT_ARRAY_BUFFER,t.get(L).buffer))}function c(){return e.createVertexArray()}function l(C){return e.bindVertexArray(C)}function u(C){return e.deleteVertexArray(C)}function h(C,N,B,I){let L=I.wireframe===!0,k=i[N.id];k===void 0&&(k={},i[N.id]=k);let F=C.isInstancedMesh===!0?C.id:0,Z=k[F];Z===void 0&&(Z={},k[F]=Z);let U=Z[B.id];U===void 0&&(U={},Z[B.id]=U);let G=U[L];return G===void 0&&(G=f(c()),U[L]=G),G}function f(C){let N=[],B=[],I=[];for(let L=0;L<n;L++)N[L]=0,B[L]=0,I[L]=0;return{geometry:null,program:null,wireframe:!1,newAttributes:N,enabledAttributes:B,attributeDivisors:I,object:C,attributes:{},index:null}}function d(C,N,B,I){let L=s.attributes,k=N.attributes,F=0,Z=B.getAttributes();for(let U in Z)if(Z[U].location>=0){let q=L[U],st=k[U];if(st===void 0&&(U==="instanceMatrix"&&C.instanceMatrix&&(st=C.instanceMatrix),U==="instanceColor"&&C.instanceColor&&(st=C.instanceColor)),q===void 0||q.attribute!==st||st&&q.data!==st.data)return!0;F++}return s.attributesNum!==F||s.index!==I}function p(C,N,B,I){let L={},k=N.attributes,F=0,Z=B.getAttributes();for(let U in Z)if(Z[U].location>=0){let q=k[U];q===void 0&&(U==="instanceMatrix"&&C.instanceMatrix&&(q=C.instanceMatrix),U==="instanceColor"&&C.instanceColor&&(q=C.instanceColor));let st={};st.attribute=q,q&&q.data&&(st.data=q.data),L[U]=st,F++}s.attributes=L,s.attributesNum=F,s.index=I}function y(){let C=s.newAttributes;for(let N=0,B=C.length;N<B;N++)C[N]=0}function m(C){g(C,0)}function g(C,N){let B=s.newAttributes,I=s.enabledAttributes,L=s.attributeDivisors;B[C]=1,I[C]===0&&(e.enableVertexAttribArray(C),I[C]=1),L[C]!==N&&(e.vertexAttribDivisor(C,N),L[C]=N)}function v(){let C=s.newAttributes,N=s.enabledAttributes;for(let B=0,I=N.length;B<I;B++)N[B]!==C[B]&&(e.disableVertexAttribArray(B),N[B]=0)}function S(C,N,B,I,L,k,F){F===!0?e.vertexAttribIPointer(C,N,B,L,k):e.vertexAttribPointer(C,N,B,I,L,k)}function _(C,N,B,I){y();let L=I.attributes,k=B.getAttributes(),F=N.defaultAttributeValues;for(let Z in k){let U=k[Z];if(U.location>=0){let G=L[Z];if(G===void 0&&(Z==="instanceMatrix"&&C.instanceMatrix&&(G=C.instanceMatrix),Z==="instanceColor"&&C.instanceColor&&(G=C.instanceColor)),G!==void 0){let q=G.normalized,st=G.itemSize,ct=t.get(G);if(ct===void 0)continue;let $=ct.buffer,at=ct.type,ft=ct.bytesPerElement,ot=at===e.INT||at===e.UNSIGNED_INT||G.gpuType===gf;if(G.isInterleavedBufferAttribute){let rt=G.data,J=rt.isInterleavedBuffer===!0?rt.stride:rt.itemSize,gt=G.offset;if(rt.isInstancedInterleavedBuffer||rt.isInstancedBufferAttribute){for(let lt=0;lt<U.locationSize;lt++)g(U.location+lt,rt.meshPerAttribute);C.isInstancedMesh!==!0&&I._maxInstanceCount===void 0&&(I._maxInstanceCount=rt.meshPerAttribute*rt.count)}else for(let lt=0;lt<U.locationSize;lt++)m(U.location+lt);e.bindBuffer(e.ARRAY_BUFFER,$);for(let lt=0;lt<U.locationSize;lt++)S(U.location+lt,st/U.locationSize,at,q,J*ft,(gt+st/U.locationSize*lt)*ft,ot)}else{if(G.isInstancedBufferAttribute){for(let rt=0;rt<U.locationSize;rt++)g(U.location+rt,G.meshPerAttribute);C.isInstancedMesh!==!0&&I._maxInstanceCount===void 0&&(I._maxInstanceCount=G.meshPerAttribute*G.count)}else for(let rt=0;rt<U.locationSize;rt++)m(U.location+rt);e.bindBuffer(e.ARRAY_BUFFER,$);for(let rt=0;rt<U.locationSize;rt++)S(U.location+rt,st/U.locationSize,at,q,st*ft,st/U.locationSize*rt*ft,ot)}}else if(F!==void 0){let q=F[Z];if(q!==void 0)switch(q.length){case 2:e.vertexAttrib2fv(U.location,q);break;case 3:e.vertexAttrib3fv(U.location,q);break;case 4:e.vertexAttrib4fv(U.location,q);break;default:e.vertexAttrib1fv(U.location,q)}}}}v()}function w(){R();for(let C in i){let N=i[C];for(let B in N){let I=N[B];for(let L in I){let k=I[L];for(let F in k)u(k[F].object),delete k[F];delete I[L]}}delete i[C]}}function b(C){if(i[C.id]===void 0)return;let N=i[C.id];for(let B in N){let I=N[B];for(let L in I){let k=I[L];for(let F in k)u(k[F].object),delete k[F];delete I[L]}}delete i[C.id]}function x(C){for(let N in i){let B=i[N];for(let I in B){let L=B[I];if(L[C.id]===void 0)continue;let k=L[C.id];for(let F in k)u(k[F].object),delete k[F];delete L[C.id]}}}function M(C){for(let N in i){let B=i[N],I=C.isInstancedMesh===!0?C.id:0,L=B[I];if(L!==void 0){for(let k in L){let F=L[k];for(let Z in F)u(F[Z].object),delete F[Z];delete L[k]}delete B[I],Object.keys(B).length===0&&delete i[N]}}}function R(){E(),o=!0,s!==r&&(s=r,l(s.object))}function E(){r.geometry=null,r.program=null,r.wireframe=!1}return{setup:a,reset:R,resetDefaultState:E,dispose:w,releaseStatesOfGeometry:b,releaseStatesOfObject:M,releaseStatesOfProgram:x,initAttributes:y,enableAttribute:m,disableUnusedAttributes:v}}function hP(e,t,n){let i;function r(c){i=c}function s(c,l){e.drawArrays(i,c,l),n.update(l,i,1)}function o(c,l,u){u!==0&&(e.drawArraysInstanced(i,c,l,u),n.update(l,i,u))}function a(c,l,u){if(u===0)return;t.get("WEBGL_multi_draw").multiDrawArraysWEBGL(i,c,0,l,0,u);let f=0;for(let d=0;d<u;d++)f+=l[d];n.update(f,i,1)}this.setMode=r,this.render=s,this.renderInstances=o,this.renderMultiDraw=a}function dP(e,t,n,i){let r;function s(){if(r!==void 0)return r;if(t.has("EXT_texture_filter_anisotropic")===!0){let x=t.get("EXT_texture_filter_anisotropic");r=e.getParameter(x.MAX_TEXTURE_MAX_ANISOTROPY_EXT)}else r=0;return r}function o(x){return!(x!==Pi&&i.convert(x)!==e.getParameter(e.IMPLEMENTATION_COLOR_READ_FORMAT))}function a(x){let M=x===Ii&&(t.has("EXT_color_buffer_half_float")||t.has("EXT_color_buffer_float"));return!(x!==On&&x!==Ri&&!M&&i.convert(x)!==e.getParameter(e.IMPLEMENTATION_COLOR_READ_TYPE))}function c(x){if(x==="highp"){if(e.getShaderPrecisionFormat(e.VERTEX_SHADER,e.HIGH_FLOAT).precision>0&&e.getShaderPrecisionFormat(e.FRAGMENT_SHADER,e.HIGH_FLOAT).precision>0)return"highp";x="mediump"}return x==="mediump"&&e.getShaderPrecisionFormat(e.VERTEX_SHADER,e.MEDIUM_FLOAT).precision>0&&e.getShaderPrecisionFormat(e.FRAGMENT_SHADER,e.MEDIUM_FLOAT).precision>0?"mediump":"lowp"}let l=n.precision!==void 0?n.precision:"highp",u=c(l);u!==l&&(Ft("WebGLRenderer:",l,"not supported, using",u,"instead."),l=u);let h=n.reversedDepthBuffer===!0&&t.has("EXT_clip_control"),f=n.logarithmicDepthBuffer===!0&&h===!1;n.reversedDepthBuffer===!0&&h===!1&&Ft("WebGLRenderer: Unable to use reversed depth buffer due to missing EXT_clip_control extension. Fallback to default depth buffer."),n.logarithmicDepthBuffer===!0&&h===!0&&Ft("WebGLRenderer: Logarithmic depth buffer is ignored when reversed depth buffer is enabled.");let d=e.getParameter(e.MAX_TEXTURE_IMAGE_UNITS),p=e.getParameter(e.MAX_VERTEX_TEXTURE_IMAGE_UNITS),y=e.getParameter(e.MAX_TEXTURE_SIZE),m=e.getParameter(e.MAX_CUBE_MAP_TEXTURE_SIZE),g=e.getParameter(e.MAX_VERTEX_ATTRIBS),v=e.getParameter(e.MAX_VERTEX_UNIFORM_VECTORS),S=e.getParameter(e.MAX_VARYING_VECTORS),_=e.getParameter(e.MAX_FRAGMENT_UNIFORM_VECTORS),w=e.getParameter(e.MAX_SAMPLES),b=e.getParameter(e.SAMPLES);return{isWebGL2:!0,getMaxAnisotropy:s,getMaxPrecision:c,textureFormatReadable:o,textureTypeReadable:a,precision:l,logarithmicDepthBuffer:f,reversedDepthBuffer:h,maxTextures:d,maxVertexTextures:p,maxTextureSize:y,maxCubemapSize:m,maxAttributes:g,maxVertexUniforms:v,maxVaryings:S,maxFragmentUniforms:_,maxSamples:w,samples:b}}function pP(e){let t=this,n=null,i=0,r=!1,s=!1,o=new Ei,a=new zt,c={value:null,needsUpdate:!1};this.uniform=c,this.numPlanes=0,this.numIntersection=0,this.init=function(h,f){let d=h.length!==0||f||i!==0||r;return r=f,i=h.length,d},this.beginShadows=function(){s=!0,u(null)},this.endShadows=function(){s=!1},this.setGlobalState=function(h,f){n=u(h,f,0)},this.setState=function(h,f,d){let p=h.clippingPlanes,y=h.clipIntersection,m=h.clipShadows,g=e.get(h);if(!r||p===null||p.length===0||s&&!m)s?u(null):l();else{let v=s?0:i,S=v*4,_=g.clippingState||null;c.value=_,_=u(p,f,S,d);for(let w=0;w!==S;++w)_[w]=n[w];g.clippingState=_,this.numIntersection=y?this.numPlanes:0,this.numPlanes+=v}};function l(){c.value!==n&&(c.value=n,c.needsUpdate=i>0),t.numPlanes=i,t.numIntersection=0}function u(h,f,d,p){let y=h!==null?h.length:0,m=null;if(y!==0){if(m=c.value,p!==!0||m===null){let g=d+y*4,v=f.matrixWorldInverse;a.getNormalMatrix(v),(m===null||m.length<g)&&(m=new Float32Array(g));for(let S=0,_=d;S!==y;++S,_+=4)o.copy(h[S]).applyMatrix4(v,a),o.normal.toArray(m,_),m[_+3]=o.constant}c.value=m,c.needsUpdate=!0}return t.numPlanes=y,t.numIntersection=0,m}}var Zc=class extends qn{constructor(t=1,n={}){super(t,t,n),this.isWebGLCubeRenderTarget=!0;let i={width:t,height:t,depth:1},r=[i,i,i,i,i,i];this.texture=new Cc(r),this._setTextureOptions(n),this.texture.isRenderTargetTexture=!0}fromEquirectangularTexture(t,n){this.texture.type=n.type,this.texture.colorSpace=n.colorSpace,this.texture.generateMipmaps=n.generateMipmaps,this.texture.minFilter=n.minFilter,this.texture.magFilter=n.magFilter;let i={uniforms:{tEquirect:{value:null}},vertexShader:`

				varying vec3 vWorldDirection;

				vec3 transformDirection( in vec3 dir, in mat4 matrix ) {

					return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );

				}

				void main() {

					vWorldDirection = transformDirection( position, modelMatrix );

					#include <begin_vertex>
					#include <project_vertex>

				}
			`,fragmentShader:`

				uniform sampler2D tEquirect;

				varying vec3 vWorldDirection;

				#include <common>

				void main() {

					vec3 direction = normalize( vWorldDirection );

					vec2 sampleUV = equirectUv( direction );

					gl_FragColor = texture2D( tEquirect, sampleUV );

				}
			`},r=new ds(5,5,5),s=new qi({name:"CubemapFromEquirect",uniforms:Qs(i.uniforms),vertexShader:i.vertexShader,fragmentShader:i.fragmentShader,side:Tn,blending:Zs});s.uniforms.tEquirect.value=n;let o=new Yn(r,s),a=n.minFilter;return n.minFilter===Pr&&(n.minFilter=Mn),new ea(1,10,this).update(t,o),n.minFilter=a,o.geometry.dispose(),o.material.dispose(),this}clear(t,n=!0,i=!0,r=!0){let s=t.getRenderTarget();for(let o=0;o<6;o++)t.setRenderTarget(this,o),t.clear(n,i,r);t.setRenderTarget(s)}},hb=256,mP=3,gP=20,Fb=256,Ub=16,yP=3,xP=new W,_P=new Zt,eh=class e{constructor(t){this._renderer=t,this._cubeSize=0,this._sourceTarget=null,this._cubeCamera=new ea(1,10,null),this._boxMesh=new Yn(new ds(5,5,5),null),this._cubemapMaterial=null,this._equirectMaterial=null,this._blurMaterial=null,this._ggxMaterial=null,this._integrationMaterial=null}fromScene(t,n=0,i=.1,r=100,s={}){let{size:o=256,position:a=xP}=s,c=this._renderer;this._setSize(o);let l=this._allocateTarget(),u=this._getSourceTarget(!0);n>0&&(u.texture.mipmapsAutoUpdate=!1);let h=c.autoClear,f=c.autoClearColor,d=c.autoClearDepth,p=c.autoClearStencil,y=t.background;c.autoClear=!0,c.autoClearColor=!0,c.autoClearDepth=!0,c.autoClearStencil=!0,y===null&&(t.background=c.getClearColor(_P));let m=new ea(i,r,u);return m.position.copy(a),m.update(c,t),c.autoClear=h,c.autoClearColor=f,c.autoClearDepth=d,c.autoClearStencil=p,t.background=y,n>0&&(u.texture.mipmapsAutoUpdate=!0,this._blur(l,n)),this._applyPMREM(l),l}fromEquirectangular(t,n=null){return this._fromTexture(t,n)}fromCubemap(t,n=null){return this._fromTexture(t,n)}compileCubemapShader(){this._cubemapMaterial===null&&(this._cubemapMaterial=mb(),this._compileMaterial(this._cubemapMaterial))}compileEquirectangularShader(){this._equirectMaterial===null&&(this._equirectMaterial=pb(),this._compileMaterial(this._equirectMaterial))}dispose(){this._sourceTarget!==null&&this._sourceTarget.dispose(),this._cubemapMaterial!==null&&this._cubemapMaterial.dispose(),this._equirectMaterial!==null&&this._equirectMaterial.dispose(),this._blurMaterial!==null&&this._blurMaterial.dispose(),this._ggxMaterial!==null&&this._ggxMaterial.dispose(),this._integrationMaterial!==null&&this._integrationMaterial.dispose(),this._boxMesh.geometry.dispose()}static lodToRoughness(t,n){return n>0?1-Math.sqrt(1-t/n):0}_setSize(t){this._cubeSize=Math.max(hb,Sm(t))}_fromTexture(t,n){t.mapping===Ks||t.mapping===ra?this._setSize(t.image.length===0?hb:t.image[0].width||t.image[0].image.width):this._setSize(t.image.width/4);let i=n||this._allocateTarget();return this._textureToCubemap(t),this._applyPMREM(i),i}_allocateTarget(){let t=this._cubeSize,n=db(t,!1,!1),i=Math.log2(t)-mP;for(let r=0;r<=i;r++)n.texture.mipmaps.push({width:t>>r,height:t>>r});return n.texture.name="PMREM",n.texture.isPMREMTexture=!0,n}_getSourceTarget(t=!1){let n=this._cubeSize,i=this._sourceTarget;return(i===null||i.width!==n||t&&i.depthBuffer===!1)&&(i!==null&&i.dispose(),this._sourceTarget=db(n,!0,t)),this._sourceTarget}_compileMaterial(t){this._boxMesh.material=t,this._renderer.compile(this._boxMesh,this._cubeCamera.children[0])}_renderCube(t,n,i){let r=this._boxMesh,s=this._cubeCamera;r.material=i,s.renderTarget=t,s.activeMipmapLevel=n;let o=t.width>>n;t.viewport.set(0,0,o,o),s.update(this._renderer,r),t.viewport.set(0,0,t.width,t.height)}_textureToCubemap(t){let n;t.mapping===Ks||t.mapping===ra?(this._cubemapMaterial===null&&(this._cubemapMaterial=mb()),n=this._cubemapMaterial,n.uniforms.flipEnvMap.value=t.isRenderTargetTexture===!1?-1:1):(this._equirectMaterial===null&&(this._equirectMaterial=pb()),n=this._equirectMaterial),n.uniforms.envMap.value=t,this._renderCube(this._getSourceTarget(),0,n)}_applyPMREM(t){this._ggxMaterial===null&&(this._ggxMaterial=vP(),this._integrationMaterial=bP());let n=this._cubeSize,i=t.texture.mipmaps.length-1,r=this._ggxMaterial.uniforms;r.envMap.value=this._sourceTarget.texture;let s=this._integrationMaterial.uniforms;s.envMap.value=this._sourceTarget.texture,s.sourceLod.value=Math.log2(n/Ub);for(let o=0;o<=i;o++){let a=e.lodToRoughness(o,i);if(o>i-yP)s.roughness.value=a,this._renderCube(t,o,this._integrationMaterial);else{let c=a>0?Math.log2(n)+.5*Math.log2(6/(Fb*Math.pow(a,4)))+.5:0;r.roughness.value=a,r.lodBias.value=c,this._renderCube(t,o,this._ggxMaterial)}}}_blur(t,n){this._blurMaterial===null&&(this._blurMaterial=MP());let i=this._blurMaterial,r=i.uniforms,s=this._sourceTarget;r.sigma.value=Math.min(n,Math.PI)/Math.SQRT2,r.envMap.value=s.texture,this._renderCube(t,0,i),r.envMap.value=t.texture,this._renderCube(s,0,i)}};function db(e,t,n){return new Zc(e,{minFilter:Pr,generateMipmaps:t,type:Ii,colorSpace:vc,depthBuffer:n})}function Jc(e,t,n){return new qi({name:e,uniforms:t,vertexShader:Jt.cube_vert,fragmentShader:n,side:Tn,blending:Zs,depthTest:!1,depthWrite:!1})}function vP(){return Jc("PMREMGGXConvolution",{envMap:{value:null},roughness:{value:0},lodBias:{value:0}},`

		#define GGX_SAMPLES ${Fb}u

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float roughness;
		uniform float lodBias;

		#include <common>

		// Van der Corput radical inverse
		float radicalInverse_VdC( uint bits ) {

			bits = ( bits << 16u ) | ( bits >> 16u );
			bits = ( ( bits & 0x55555555u ) << 1u ) | ( ( bits & 0xAAAAAAAAu ) >> 1u );
			bits = ( ( bits & 0x33333333u ) << 2u ) | ( ( bits & 0xCCCCCCCCu ) >> 2u );
			bits = ( ( bits & 0x0F0F0F0Fu ) << 4u ) | ( ( bits & 0xF0F0F0F0u ) >> 4u );
			bits = ( ( bits & 0x00FF00FFu ) << 8u ) | ( ( bits & 0xFF00FF00u ) >> 8u );
			return float( bits ) * 2.3283064365386963e-10; // / 0x100000000

		}

		// Hammersley sequence
		vec2 hammersley( uint i, uint N ) {

			return vec2( float( i ) / float( N ), radicalInverse_VdC( i ) );

		}

		void main() {

			vec3 N = normalize( vWorldDirection );

			// For very low roughness, just sample the environment directly
			if ( roughness < 0.001 ) {

				gl_FragColor = vec4( textureLod( envMap, N, 0.0 ).rgb, 1.0 );
				return;

			}

			float alpha = roughness * roughness;
			float alpha2 = alpha * alpha;

			// Tangent space basis for VNDF sampling
			vec3 up = abs( N.z ) < 0.999 ? vec3( 0.0, 0.0, 1.0 ) : vec3( 1.0, 0.0, 0.0 );
			vec3 tangent = normalize( cross( up, N ) );
			vec3 bitangent = cross( N, tangent );

			vec3 prefilteredColor = vec3( 0.0 );
			float totalWeight = 0.0;

			for ( uint i = 0u; i < GGX_SAMPLES; i ++ ) {

				vec2 Xi = hammersley( i, GGX_SAMPLES );

				// With V = N, sample the reflected direction directly.
				float invQ = 1.0 / ( 1.0 - Xi.x + alpha2 * Xi.x );
				float NdotL = ( 1.0 - Xi.x - alpha2 * Xi.x ) * invQ;

				if ( NdotL > 0.0 ) {

					float phi = 2.0 * PI * Xi.y;
					float sinTheta = 2.0 * alpha * sqrt( Xi.x * ( 1.0 - Xi.x ) ) * invQ;
					vec3 L = N * NdotL + ( tangent * cos( phi ) + bitangent * sin( phi ) ) * sinTheta;

					// Match the source mip to the sample's solid angle. The terms
					// independent of the sample are precomputed in lodBias.
					float d = alpha2 * invQ;
					float lod = max( log2( d ) + lodBias, 0.0 );

					// Weight by NdotL for the split-sum approximation
					prefilteredColor += textureLod( envMap, L, lod ).rgb * NdotL;
					totalWeight += NdotL;

				}

			}

			gl_FragColor = vec4( prefilteredColor / totalWeight, 1.0 );

		}
	`)}function bP(){return Jc("PMREMGGXIntegration",{envMap:{value:null},roughness:{value:0},sourceLod:{value:0},sourceSize:{value:Ub}},`

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float roughness;
		uniform float sourceLod;
		uniform int sourceSize;

		void main() {

			vec3 N = normalize( vWorldDirection );

			float alpha = roughness * roughness;
			float alpha2 = alpha * alpha;

			float texelSize = 2.0 / float( sourceSize );

			vec3 prefilteredColor = vec3( 0.0 );
			float totalWeight = 0.0;

			// Pair opposite texels: only the one in N's hemisphere contributes.
			for ( int face = 0; face < 3; face ++ ) {

				for ( int y = 0; y < sourceSize; y ++ ) {

					for ( int x = 0; x < sourceSize; x ++ ) {

						vec2 uv = ( vec2( x, y ) + 0.5 ) * texelSize - 1.0;
						vec3 texelDirection = face == 0 ? vec3( 1.0, uv ) : ( face == 1 ? vec3( uv.x, 1.0, uv.y ) : vec3( uv, 1.0 ) );

						float invDistance = inversesqrt( 1.0 + dot( uv, uv ) );
						float NdotL = dot( N, texelDirection );
						texelDirection *= NdotL < 0.0 ? - 1.0 : 1.0;
						NdotL = abs( NdotL ) * invDistance;

						// With V = N, NdotH squared is ( 1 + NdotL ) / 2. Common factors
						// in the GGX distribution and texel solid angle cancel when normalized.
						float d = 1.0 + alpha2 + ( alpha2 - 1.0 ) * NdotL;
						float weight = NdotL * invDistance * invDistance * invDistance / ( d * d );

						prefilteredColor += textureLod( envMap, texelDirection, sourceLod ).rgb * weight;
						totalWeight += weight;

					}

				}

			}

			gl_FragColor = vec4( prefilteredColor / totalWeight, 1.0 );

		}
	`)}function MP(){return Jc("PMREMSphericalGaussianBlur",{envMap:{value:null},sigma:{value:0}},`

		#define SAMPLES ${gP}
		#define GOLDEN_ANGLE 2.39996322973

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float sigma;

		#include <common>

		void main() {

			vec3 outputDirection = normalize( vWorldDirection );

			vec3 up = abs( outputDirection.z ) < 0.999 ? vec3( 0.0, 0.0, 1.0 ) : vec3( 1.0, 0.0, 0.0 );
			vec3 tangent = normalize( cross( up, outputDirection ) );
			vec3 bitangent = cross( outputDirection, tangent );

			// Truncate the kernel at three standard deviations or at the antipode.
			float thetaMax = min( 3.0 * sigma, PI );
			float truncation = 1.0 - exp( - 0.5 * thetaMax * thetaMax / ( sigma * sigma ) );

			vec3 accumColor = vec3( 0.0 );
			float accumWeight = 0.0;

			for ( int i = 0; i < SAMPLES; i ++ ) {

				// Stratified inverse-CDF sampling of the Gaussian, placed on a golden-angle spiral.
				float stratum = ( float( i ) + 0.5 ) / float( SAMPLES );
				float theta = sigma * sqrt( - 2.0 * log( 1.0 - stratum * truncation ) );
				float phi = float( i ) * GOLDEN_ANGLE;

				vec3 offset = cos( phi ) * tangent + sin( phi ) * bitangent;
				vec3 sampleDirection = cos( theta ) * outputDirection + sin( theta ) * offset;

				// Correct the planar sample density to solid angle.
				float weight = sin( theta ) / theta;

				accumColor += weight * textureLod( envMap, sampleDirection, 0.0 ).rgb;
				accumWeight += weight;

			}

			gl_FragColor = vec4( accumColor / accumWeight, 1.0 );

		}
	`)}function pb(){return Jc("PMREMEquirectangularToCubemap",{envMap:{value:null}},`

		varying vec3 vWorldDirection;

		uniform sampler2D envMap;

		#include <common>

		void main() {

			// Average four subpixel samples to preserve small, bright features.
			vec3 direction = normalize( vWorldDirection );
			vec3 dx = dFdx( direction ) * 0.25;
			vec3 dy = dFdy( direction ) * 0.25;

			vec3 color = textureLod( envMap, equirectUv( normalize( direction - dx - dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction + dx - dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction - dx + dy ) ), 0.0 ).rgb;
			color += textureLod( envMap, equirectUv( normalize( direction + dx + dy ) ), 0.0 ).rgb;
			gl_FragColor = vec4( color * 0.25, 1.0 );

		}
	`)}function mb(){return Jc("PMREMCubemapToCubemap",{envMap:{value:null},flipEnvMap:{value:-1}},`

		varying vec3 vWorldDirection;

		uniform samplerCube envMap;
		uniform float flipEnvMap;

		void main() {

			gl_FragColor = vec4( textureCube( envMap, vec3( flipEnvMap * vWorldDirection.x, vWorldDirection.yz ) ).rgb, 1.0 );

		}
	`)}function SP(e){let t=new WeakMap,n=new WeakMap,i=null;function r(f,d=!1){return f==null?null:d?o(f):s(f)}function s(f){if(f&&f.isTexture){let d=f.mapping;if(d===df||d===pf)if(t.has(f)){let p=t.get(f).texture;return a(p,f.mapping)}else{let p=f.image;if(p&&p.height>0){let y=new Zc(p.height);return y.fromEquirectangularTexture(e,f),t.set(f,y),f.addEventListener("dispose",l),a(y.texture,f.mapping)}else return null}}return f}function o(f){if(f&&f.isTexture&&f.isPMREMTexture!==!0){let d=f.mapping,p=d===df||d===pf,y=d===Ks||d===ra;if(p||y){let m=n.get(f),g=m!==void 0?m.texture.pmremVersion:0;if(f.isRenderTargetTexture&&f.pmremVersion!==g)return i===null&&(i=new eh(e)),m=p?i.fromEquirectangular(f,m):i.fromCubemap(f,m),m.texture.pmremVersion=f.pmremVersion,n.set(f,m),m.texture;if(m!==void 0)return m.texture;{let v=f.image;return p&&v&&v.height>0||y&&v&&c(v)?(i===null&&(i=new eh(e)),m=p?i.fromEquirectangular(f):i.fromCubemap(f),m.texture.pmremVersion=f.pmremVersion,n.set(f,m),f.addEventListener("dispose",u),m.texture):null}}}return f}function a(f,d){return d===df?f.mapping=Ks:d===pf&&(f.mapping=ra),f}function c(f){let d=0,p=6;for(let y=0;y<p;y++)f[y]!==void 0&&d++;return d===p}function l(f){let d=f.target;d.removeEventListener("dispose",l);let p=t.get(d);p!==void 0&&(t.delete(d),p.dispose())}function u(f){let d=f.target;d.removeEventListener("dispose",u);let p=n.get(d);p!==void 0&&(n.delete(d),p.dispose())}function h(){t=new WeakMap,n=new WeakMap,i!==null&&(i.dispose(),i=null)}return{get:r,dispose:h}}function wP(e){let t={};function n(i){if(t[i]!==void 0)return t[i];let r=e.getExtension(i);return t[i]=r,r}return{has:function(i){return n(i)!==null},init:function(){n("EXT_color_buffer_float"),n("WEBGL_clip_cull_distance"),n("OES_texture_float_linear"),n("EXT_color_buffer_half_float"),n("WEBGL_multisampled_render_to_texture"),n("WEBGL_render_shared_exponent")},get:function(i){let r=n(i);return r===null&&gc("WebGLRenderer: "+i+" extension not supported."),r}}}function TP(e,t,n,i){let r={},s=new WeakMap,o=new FinalizationRegistry(p=>delete r[p]);function a(p){c(p.target)}function c(p){p.index!==null&&t.remove(p.index);for(let m in p.attributes)t.remove(p.attributes[m]);p.removeEventListener("dispose",a),delete r[p.id],o.unregister(p);let y=s.get(p);y&&(t.remove(y),s.delete(p)),i.releaseStatesOfGeometry(p),p.isInstancedBufferGeometry===!0&&delete p._maxInstanceCount,n.memory.geometries--}function l(p,y){return r[y.id]!==void 0||(y.addEventListener("dispose",a),r[y.id]=new WeakRef(y),o.register(y,y.id,y),n.memory.geometries++),y}function u(p){let y=p.attributes;for(let m in y)t.update(y[m],e.ARRAY_BUFFER)}function h(p){let y=p.index,m=p.attributes.position,g=0;if(m===void 0)return;let v=y!==null?y.array.length:m.array.length/3-1,S=m.count>=65535?Ec:Ac,_=new S(Math.ceil(v/3)*6,1),w=_.array;if(y!==null){let x=y.array;g=y.version;for(let M=0,R=0;M<v;M+=3){let E=x[M+0],C=x[M+1],N=x[M+2];w[R++]=E,w[R++]=C,w[R++]=C,w[R++]=N,w[R++]=N,w[R++]=E}}else{g=m.version;for(let x=0,M=0;x<v;x+=3){let R=x+0,E=x+1,C=x+2;w[M++]=R,w[M++]=E,w[M++]=E,w[M++]=C,w[M++]=C,w[M++]=R}}_.version=g;let b=s.get(p);b&&t.remove(b),s.set(p,_)}function f(p){let y=s.get(p);if(y){let m=p.index;m!==null&&y.version<m.version&&h(p)}else h(p);return s.get(p)}function d(){for(let p in r){let y=r[p].deref();y!==void 0&&c(y)}}return{get:l,update:u,getWireframeAttribute:f,dispose:d}}function AP(e,t,n){let i;function r(h){i=h}let s,o;function a(h){s=h.type,o=h.bytesPerElement}function c(h,f){e.drawElements(i,f,s,h*o),n.update(f,i,1)}function l(h,f,d){d!==0&&(e.drawElementsInstanced(i,f,s,h*o,d),n.update(f,i,d))}function u(h,f,d){if(d===0)return;t.get("WEBGL_multi_draw").multiDrawElementsWEBGL(i,f,0,s,h,0,d);let y=0;for(let m=0;m<d;m++)y+=f[m];n.update(y,i,1)}this.setMode=r,this.setIndex=a,this.render=c,this.renderInstances=l,this.renderMultiDraw=u}function EP(e){let t={geometries:0,textures:0},n={frame:0,calls:0,triangles:0,points:0,lines:0};function i(s,o,a){switch(n.calls++,o){case e.TRIANGLES:n.triangles+=a*(s/3);break;case e.LINES:n.lines+=a*(s/2);break;case e.LINE_STRIP:n.lines+=a*(s-1);break;case e.LINE_LOOP:n.lines+=a*s;break;case e.POINTS:n.points+=a*s;break;default:kt("WebGLInfo: Unknown draw mode:",o);break}}function r(){n.calls=0,n.triangles=0,n.points=0,n.lines=0}return{memory:t,render:n,programs:null,autoReset:!0,reset:r,update:i}}function CP(e,t,n){let i=new WeakMap,r=new Te;function s(o,a,c){let l=o.morphTargetInfluences,u=a.morphAttributes.position||a.morphAttributes.normal||a.morphAttributes.color,h=u!==void 0?u.length:0,f=i.get(a);if(f===void 0||f.count!==h){let R=function(){x.dispose(),i.delete(a),a.removeEventListener("dispose",R)};f!==void 0&&f.texture.dispose();let d=a.morphAttributes.position!==void 0,p=a.morphAttributes.normal!==void 0,y=a.morphAttributes.color!==void 0,m=a.morphAttributes.position||[],g=a.morphAttributes.normal||[],v=a.morphAttributes.color||[],S=0;d===!0&&(S=1),p===!0&&(S=2),y===!0&&(S=3);let _=a.attributes.position.count*S,w=1;_>t.maxTextureSize&&(w=Math.ceil(_/t.maxTextureSize),_=t.maxTextureSize);let b=new Float32Array(_*w*4*h),x=new Sc(b,_,w,h);x.type=Ri,x.needsUpdate=!0;let M=S*4;for(let E=0;E<h;E++){let C=m[E],N=g[E],B=v[E],I=_*w*4*E;for(let L=0;L<C.count;L++){let k=L*M;d===!0&&(r.fromBufferAttribute(C,L),b[I+k+0]=r.x,b[I+k+1]=r.y,b[I+k+2]=r.z,b[I+k+3]=0),p===!0&&(r.fromBufferAttribute(N,L),b[I+k+4]=r.x,b[I+k+5]=r.y,b[I+k+6]=r.z,b[I+k+7]=0),y===!0&&(r.fromBufferAttribute(B,L),b[I+k+8]=r.x,b[I+k+9]=r.y,b[I+k+10]=r.z,b[I+k+11]=B.itemSize===4?r.w:1)}}f={count:h,texture:x,size:new ie(_,w)},i.set(a,f),a.addEventListener("dispose",R)}if(o.isInstancedMesh===!0&&o.morphTexture!==null)c.getUniforms().setValue(e,"morphTexture",o.morphTexture,n);else{let d=0;for(let y=0;y<l.length;y++)d+=l[y];let p=a.morphTargetsRelative?1:1-d;c.getUniforms().setValue(e,"morphTargetBaseInfluence",p),c.getUniforms().setValue(e,"morphTargetInfluences",l)}c.getUniforms().setValue(e,"morphTargetsTexture",f.texture,n),c.getUniforms().setValue(e,"morphTargetsTextureSize",f.size)}return{update:s}}function RP(e,t,n,i,r){let s=new WeakMap;function o(l){let u=r.render.frame,h=l.geometry,f=t.get(l,h);if(s.get(f)!==u&&(t.update(f),s.set(f,u)),l.isInstancedMesh&&(l.hasEventListener("dispose",c)===!1&&l.addEventListener("dispose",c),s.get(l)!==u&&(n.update(l.instanceMatrix,e.ARRAY_BUFFER),l.instanceColor!==null&&n.update(l.instanceColor,e.ARRAY_BUFFER),s.set(l,u))),l.isSkinnedMesh){let d=l.skeleton;s.get(d)!==u&&(d.update(),s.set(d,u))}return f}function a(){s=new WeakMap}function c(l){let u=l.target;u.removeEventListener("dispose",c),i.releaseStatesOfObject(u),n.remove(u.instanceMatrix),u.instanceColor!==null&&n.remove(u.instanceColor)}return{update:o,dispose:a}}var IP={[nm]:"LINEAR_TONE_MAPPING",[im]:"REINHARD_TONE_MAPPING",[rm]:"CINEON_TONE_MAPPING",[sm]:"ACES_FILMIC_TONE_MAPPING",[am]:"AGX_TONE_MAPPING",[cm]:"NEUTRAL_TONE_MAPPING",[om]:"CUSTOM_TONE_MAPPING"};function PP(e,t,n,i,r,s){let o=new qn(t,n,{type:e,depthBuffer:r,stencilBuffer:s,samples:i?4:0,storeMultisampledDepthBuffer:!1,storeMultisampledStencilBuffer:!1,resolveDepthBuffer:!1,resolveStencilBuffer:!1}),a=null,c=null,l=null,u=new ri;u.setAttribute("position",new Ke([-1,3,0,-1,-1,0,3,-1,0],3)),u.setAttribute("uv",new Ke([0,2,0,0,2,0],2));let h=new Ju({uniforms:{tDiffuse:{value:null}},vertexShader:`
			precision highp float;

			uniform mat4 modelViewMatrix;
			uniform mat4 projectionMatrix;

			attribute vec3 position;
			attribute vec2 uv;

			varying vec2 vUv;

			void main() {
				vUv = uv;
				gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 );
			}`,fragmentShader:`
			precision highp float;

			uniform sampler2D tDiffuse;

			varying vec2 vUv;

			#include <tonemapping_pars_fragment>
			#include <colorspace_pars_fragment>

			void main() {
				gl_FragColor = texture2D( tDiffuse, vUv );

				#ifdef LINEAR_TONE_MAPPING
					gl_FragColor.rgb = LinearToneMapping( gl_FragColor.rgb );
				#elif defined( REINHARD_TONE_MAPPING )
					gl_FragColor.rgb = ReinhardToneMapping( gl_FragColor.rgb );
				#elif defined( CINEON_TONE_MAPPING )
					gl_FragColor.rgb = CineonToneMapping( gl_FragColor.rgb );
				#elif defined( ACES_FILMIC_TONE_MAPPING )
					gl_FragColor.rgb = ACESFilmicToneMapping( gl_FragColor.rgb );
				#elif defined( AGX_TONE_MAPPING )
					gl_FragColor.rgb = AgXToneMapping( gl_FragColor.rgb );
				#elif defined( NEUTRAL_TONE_MAPPING )
					gl_FragColor.rgb = NeutralToneMapping( gl_FragColor.rgb );
				#elif defined( CUSTOM_TONE_MAPPING )
					gl_FragColor.rgb = CustomToneMapping( gl_FragColor.rgb );
				#endif

				#ifdef SRGB_TRANSFER
					gl_FragColor = sRGBTransferOETF( gl_FragColor );
				#endif
			}`,depthTest:!1,depthWrite:!1}),f=new Yn(u,h),d=new Uc(-1,1,1,-1,0,1),p=null,y=null,m=!1,g,v=null,S=[],_=!1;this.setSize=function(w,b){o.setSize(w,b),a!==null&&a.setSize(w,b),c!==null&&c.setSize(w,b);for(let x=0;x<S.length;x++){let M=S[x];M.setSize&&M.setSize(w,b)}},this.setEffects=function(w){S=w,_=S.length>0&&S[0].isRenderPass===!0;let b=o.width,x=o.height;S.length>0&&a===null&&(a=new qn(b,x,{type:Ii,depthBuffer:!1,stencilBuffer:!1}),c=new qn(b,x,{type:Ii,depthBuffer:!1,stencilBuffer:!1}));let M=r===!0&&S.some(R=>R.needsDepthTexture===!0);M!==(o.depthTexture!==null)&&(M===!0&&l===null&&(l=new Ir(b,x),s===!0&&(l.format=Lr,l.type=js)),o.dispose(),o.depthTexture=M?l:null,o.resolveDepthBuffer=M,o.storeMultisampledDepthBuffer=M);for(let R=0;R<S.length;R++){let E=S[R];E.setSize&&E.setSize(b,x),M&&E.needsDepthTexture===!0&&E.setDepthTexture&&E.setDepthTexture(l)}},this.begin=function(w,b){if(m||w.toneMapping===Yi&&S.length===0)return!1;if(v=b,b!==null){let x=b.width,M=b.height;(o.width!==x||o.height!==M)&&this.setSize(x,M)}return _===!1&&w.setRenderTarget(o),g=w.toneMapping,w.toneMapping=Yi,!0},this.hasRenderPass=function(){return _},this.end=function(w,b){w.toneMapping=g,m=!0;let x=o,M=a;for(let R=0;R<S.length;R++){let E=S[R];E.enabled!==!1&&(E.render(w,M,x,b),E.needsSwap!==!1&&(x=M,M=M===a?c:a))}if(p!==w.outputColorSpace||y!==w.toneMapping){p=w.outputColorSpace,y=w.toneMapping,h.defines={},ee.getTransfer(p)===ue&&(h.defines.SRGB_TRANSFER="");let R=IP[y];R&&(h.defines[R]=""),h.needsUpdate=!0}h.uniforms.tDiffuse.value=x.texture,w.setRenderTarget(v),w.render(f,d),v=null,m=!1},this.isCompositing=function(){return m},this.dispose=function(){o.dispose(),a!==null&&a.dispose(),c!==null&&c.dispose(),u.dispose(),h.dispose()}}var Ob=new Fn,Bb=new Ir(1,1),kb=new Rc(1),zb=new Sc,Gb=new $u,Vb=new Cc,gb=[],yb=[],xb=new Float32Array(16),_b=new Float32Array(9),vb=new Float32Array(4);function ca(e,t,n){let i=e[0];if(i<=0||i>0)return e;let r=t*n,s=gb[r];if(s===void 0&&(s=new Float32Array(r),gb[r]=s),t!==0){i.toArray(s,0);for(let o=1,a=0;o!==t;++o)a+=n,e[o].toArray(s,a)}return s}function Ge(e,t){if(e.length!==t.length)return!1;for(let n=0,i=e.length;n<i;n++)if(e[n]!==t[n])return!1;return!0}function Ve(e,t){for(let n=0,i=t.length;n<i;n++)e[n]=t[n]}function ih(e,t){let n=yb[t];n===void 0&&(n=new Int32Array(t),yb[t]=n);for(let i=0;i!==t;++i)n[i]=e.allocateTextureUnit();return n}function LP(e,t){let n=this.cache;n[0]!==t&&(e.uniform1f(this.addr,t),n[0]=t)}function NP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y)&&(e.uniform2f(this.addr,t.x,t.y),n[0]=t.x,n[1]=t.y);else{if(Ge(n,t))return;e.uniform2fv(this.addr,t),Ve(n,t)}}function DP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y||n[2]!==t.z)&&(e.uniform3f(this.addr,t.x,t.y,t.z),n[0]=t.x,n[1]=t.y,n[2]=t.z);else if(t.r!==void 0)(n[0]!==t.r||n[1]!==t.g||n[2]!==t.b)&&(e.uniform3f(this.addr,t.r,t.g,t.b),n[0]=t.r,n[1]=t.g,n[2]=t.b);else{if(Ge(n,t))return;e.uniform3fv(this.addr,t),Ve(n,t)}}function FP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y||n[2]!==t.z||n[3]!==t.w)&&(e.uniform4f(this.addr,t.x,t.y,t.z,t.w),n[0]=t.x,n[1]=t.y,n[2]=t.z,n[3]=t.w);else{if(Ge(n,t))return;e.uniform4fv(this.addr,t),Ve(n,t)}}function UP(e,t){let n=this.cache,i=t.elements;if(i===void 0){if(Ge(n,t))return;e.uniformMatrix2fv(this.addr,!1,t),Ve(n,t)}else{if(Ge(n,i))return;vb.set(i),e.uniformMatrix2fv(this.addr,!1,vb),Ve(n,i)}}function OP(e,t){let n=this.cache,i=t.elements;if(i===void 0){if(Ge(n,t))return;e.uniformMatrix3fv(this.addr,!1,t),Ve(n,t)}else{if(Ge(n,i))return;_b.set(i),e.uniformMatrix3fv(this.addr,!1,_b),Ve(n,i)}}function BP(e,t){let n=this.cache,i=t.elements;if(i===void 0){if(Ge(n,t))return;e.uniformMatrix4fv(this.addr,!1,t),Ve(n,t)}else{if(Ge(n,i))return;xb.set(i),e.uniformMatrix4fv(this.addr,!1,xb),Ve(n,i)}}function kP(e,t){let n=this.cache;n[0]!==t&&(e.uniform1i(this.addr,t),n[0]=t)}function zP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y)&&(e.uniform2i(this.addr,t.x,t.y),n[0]=t.x,n[1]=t.y);else{if(Ge(n,t))return;e.uniform2iv(this.addr,t),Ve(n,t)}}function GP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y||n[2]!==t.z)&&(e.uniform3i(this.addr,t.x,t.y,t.z),n[0]=t.x,n[1]=t.y,n[2]=t.z);else{if(Ge(n,t))return;e.uniform3iv(this.addr,t),Ve(n,t)}}function VP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y||n[2]!==t.z||n[3]!==t.w)&&(e.uniform4i(this.addr,t.x,t.y,t.z,t.w),n[0]=t.x,n[1]=t.y,n[2]=t.z,n[3]=t.w);else{if(Ge(n,t))return;e.uniform4iv(this.addr,t),Ve(n,t)}}function HP(e,t){let n=this.cache;n[0]!==t&&(e.uniform1ui(this.addr,t),n[0]=t)}function WP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y)&&(e.uniform2ui(this.addr,t.x,t.y),n[0]=t.x,n[1]=t.y);else{if(Ge(n,t))return;e.uniform2uiv(this.addr,t),Ve(n,t)}}function $P(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y||n[2]!==t.z)&&(e.uniform3ui(this.addr,t.x,t.y,t.z),n[0]=t.x,n[1]=t.y,n[2]=t.z);else{if(Ge(n,t))return;e.uniform3uiv(this.addr,t),Ve(n,t)}}function XP(e,t){let n=this.cache;if(t.x!==void 0)(n[0]!==t.x||n[1]!==t.y||n[2]!==t.z||n[3]!==t.w)&&(e.uniform4ui(this.addr,t.x,t.y,t.z,t.w),n[0]=t.x,n[1]=t.y,n[2]=t.z,n[3]=t.w);else{if(Ge(n,t))return;e.uniform4uiv(this.addr,t),Ve(n,t)}}function rh(e){return e.version===0&&(e.compareFunction=_m,e.needsUpdate=!0),e}function qP(e,t,n){let i=this.cache,r=n.allocateTextureUnit();i[0]!==r&&(e.uniform1i(this.addr,r),i[0]=r);let s;this.type===e.SAMPLER_2D_SHADOW?s=rh(Bb):s=Ob,n.setTexture2D(t||s,r)}function YP(e,t,n){let i=this.cache,r=n.allocateTextureUnit();i[0]!==r&&(e.uniform1i(this.addr,r),i[0]=r),n.setTexture3D(t||Gb,r)}function ZP(e,t,n){let i=this.cache,r=n.allocateTextureUnit();i[0]!==r&&(e.uniform1i(this.addr,r),i[0]=r);let s;this.type===e.SAMPLER_CUBE_SHADOW?s=rh(kb):s=Vb,n.setTextureCube(t||s,r)}function JP(e,t,n){let i=this.cache,r=n.allocateTextureUnit();i[0]!==r&&(e.uniform1i(this.addr,r),i[0]=r),n.setTexture2DArray(t||zb,r)}function KP(e){switch(e){case 5126:return LP;case 35664:return NP;case 35665:return DP;case 35666:return FP;case 35674:return UP;case 35675:return OP;case 35676:return BP;case 5124:case 35670:return kP;case 35667:case 35671:return zP;case 35668:case 35672:return GP;case 35669:case 35673:return VP;case 5125:return HP;case 36294:return WP;case 36295:return $P;case 36296:return XP;case 35678:case 36198:case 36298:case 36306:case 35682:return qP;case 35679:case 36299:case 36307:return YP;case 35680:case 36300:case 36308:case 36293:return ZP;case 36289:case 36303:case 36311:case 36292:return JP}}function jP(e,t){e.uniform1fv(this.addr,t)}function QP(e,t){let n=ca(t,this.size,2);e.uniform2fv(this.addr,n)}function tL(e,t){let n=ca(t,this.size,3);e.uniform3fv(this.addr,n)}function eL(e,t){let n=ca(t,this.size,4);e.uniform4fv(this.addr,n)}function nL(e,t){let n=ca(t,this.size,4);e.uniformMatrix2fv(this.addr,!1,n)}function iL(e,t){let n=ca(t,this.size,9);e.uniformMatrix3fv(this.addr,!1,n)}function rL(e,t){let n=ca(t,this.size,16);e.uniformMatrix4fv(this.addr,!1,n)}function sL(e,t){e.uniform1iv(this.addr,t)}function oL(e,t){e.uniform2iv(this.addr,t)}function aL(e,t){e.uniform3iv(this.addr,t)}function cL(e,t){e.uniform4iv(this.addr,t)}function lL(e,t){e.uniform1uiv(this.addr,t)}function uL(e,t){e.uniform2uiv(this.addr,t)}function fL(e,t){e.uniform3uiv(this.addr,t)}function hL(e,t){e.uniform4uiv(this.addr,t)}function dL(e,t,n){let i=this.cache,r=t.length,s=ih(n,r);Ge(i,s)||(e.uniform1iv(this.addr,s),Ve(i,s));let o;this.type===e.SAMPLER_2D_SHADOW?o=rh(Bb):o=Ob;for(let a=0;a!==r;++a)n.setTexture2D(t[a]||o,s[a])}function pL(e,t,n){let i=this.cache,r=t.length,s=ih(n,r);Ge(i,s)||(e.uniform1iv(this.addr,s),Ve(i,s));for(let o=0;o!==r;++o)n.setTexture3D(t[o]||Gb,s[o])}function mL(e,t,n){let i=this.cache,r=t.length,s=ih(n,r);Ge(i,s)||(e.uniform1iv(this.addr,s),Ve(i,s));let o;this.type===e.SAMPLER_CUBE_SHADOW?o=rh(kb):o=Vb;for(let a=0;a!==r;++a)n.setTextureCube(t[a]||o,s[a])}function gL(e,t,n){let i=this.cache,r=t.length,s=ih(n,r);Ge(i,s)||(e.uniform1iv(this.addr,s),Ve(i,s));for(let o=0;o!==r;++o)n.setTexture2DArray(t[o]||zb,s[o])}function yL(e){switch(e){case 5126:return jP;case 35664:return QP;case 35665:return tL;case 35666:return eL;case 35674:return nL;case 35675:return iL;case 35676:return rL;case 5124:case 35670:return sL;case 35667:case 35671:return oL;case 35668:case 35672:return aL;case 35669:case 35673:return cL;case 5125:return lL;case 36294:return uL;case 36295:return fL;case 36296:return hL;case 35678:case 36198:case 36298:case 36306:case 35682:return dL;case 35679:case 36299:case 36307:return pL;case 35680:case 36300:case 36308:case 36293:return mL;case 36289:case 36303:case 36311:case 36292:return gL}}var Lm=class{constructor(t,n,i){this.id=t,this.addr=i,this.cache=[],this.type=n.type,this.setValue=KP(n.type)}},Nm=class{constructor(t,n,i){this.id=t,this.addr=i,this.cache=[],this.type=n.type,this.size=n.size,this.setValue=yL(n.type)}},Dm=class{constructor(t){this.id=t,this.seq=[],this.map={}}setValue(t,n,i){let r=this.seq;for(let s=0,o=r.length;s!==o;++s){let a=r[s];a.setValue(t,n[a.id],i)}}},Im=/(\w+)(\])?(\[|\.)?/g;function bb(e,t){e.seq.push(t),e.map[t.id]=t}function xL(e,t,n){let i=e.name,r=i.length;for(Im.lastIndex=0;;){let s=Im.exec(i),o=Im.lastIndex,a=s[1],c=s[2]==="]",l=s[3];if(c&&(a=a|0),l===void 0||l==="["&&o+2===r){bb(n,l===void 0?new Lm(a,e,t):new Nm(a,e,t));break}else{let h=n.map[a];h===void 0&&(h=new Dm(a),bb(n,h)),n=h}}}var aa=class{constructor(t,n){this.seq=[],this.map={};let i=t.getProgramParameter(n,t.ACTIVE_UNIFORMS);for(let o=0;o<i;++o){let a=t.getActiveUniform(n,o),c=t.getUniformLocation(n,a.name);xL(a,c,this)}let r=[],s=[];for(let o of this.seq)o.type===t.SAMPLER_2D_SHADOW||o.type===t.SAMPLER_CUBE_SHADOW||o.type===t.SAMPLER_2D_ARRAY_SHADOW?r.push(o):s.push(o);r.length>0&&(this.seq=r.concat(s))}setValue(t,n,i,r){let s=this.map[n];s!==void 0&&s.setValue(t,i,r)}setOptional(t,n,i){let r=n[i];r!==void 0&&this.setValue(t,i,r)}static upload(t,n,i,r){for(let s=0,o=n.length;s!==o;++s){let a=n[s],c=i[a.id];c.needsUpdate!==!1&&a.setValue(t,c.value,r)}}static seqWithValue(t,n){let i=[];for(let r=0,s=t.length;r!==s;++r){let o=t[r];o.id in n&&i.push(o)}return i}};function Mb(e,t,n){let i=e.createShader(t);return e.shaderSource(i,n),e.compileShader(i),i}var _L=37297,vL=0;function bL(e,t){let n=e.split(`
`),i=[],r=Math.max(t-6,0),s=Math.min(t+6,n.length);for(let o=r;o<s;o++){let a=o+1;i.push(`${a===t?">":" "} ${a}: ${n[o]}`)}return i.join(`
`)}var Sb=new zt;function ML(e){ee._getMatrix(Sb,ee.workingColorSpace,e);let t=`mat3( ${Sb.elements.map(n=>n.toFixed(4))} )`;switch(ee.getTransfer(e)){case bc:return[t,"LinearTransferOETF"];case ue:return[t,"sRGBTransferOETF"];default:return Ft("WebGLProgram: Unsupported color space: ",e),[t,"LinearTransferOETF"]}}function wb(e,t,n){let i=e.getShaderParameter(t,e.COMPILE_STATUS),s=(e.getShaderInfoLog(t)||"").trim();if(i&&s==="")return"";let o=/ERROR: 0:(\d+)/.exec(s);if(o){let a=parseInt(o[1]);return n.toUpperCase()+`

`+s+`

`+bL(e.getShaderSource(t),a)}else return s}function SL(e,t){let n=ML(t);return[`vec4 ${e}( vec4 value ) {`,`	return ${n[1]}( vec4( ${n[0]} * value.rgb, value.a ) );`,"}"].join(`
`)}var wL={[nm]:"Linear",[im]:"Reinhard",[rm]:"Cineon",[sm]:"ACESFilmic",[am]:"AgX",[cm]:"Neutral",[om]:"Custom"};function TL(e,t){let n=wL[t];return n===void 0?(Ft("WebGLProgram: Unsupported toneMapping:",t),"vec3 "+e+"( vec3 color ) { return LinearToneMapping( color ); }"):"vec3 "+e+"( vec3 color ) { return "+n+"ToneMapping( color ); }"}var th=new W;function AL(){ee.getLuminanceCoefficients(th);let e=th.x.toFixed(4),t=th.y.toFixed(4),n=th.z.toFixed(4);return["float luminance( const in vec3 rgb ) {",`	const vec3 weights = vec3( ${e}, ${t}, ${n} );`,"	return dot( weights, rgb );","}"].join(`
`)}function EL(e){return[e.extensionClipCullDistance?"#extension GL_ANGLE_clip_cull_distance : require":"",e.extensionMultiDraw?"#extension GL_ANGLE_multi_draw : require":""].filter(Yc).join(`
`)}function CL(e){let t=[];for(let n in e){let i=e[n];i!==!1&&t.push("#define "+n+" "+i)}return t.join(`
`)}function RL(e,t){let n={},i=e.getProgramParameter(t,e.ACTIVE_ATTRIBUTES);for(let r=0;r<i;r++){let s=e.getActiveAttrib(t,r),o=s.name,a=1;s.type===e.FLOAT_MAT2&&(a=2),s.type===e.FLOAT_MAT3&&(a=3),s.type===e.FLOAT_MAT4&&(a=4),n[o]={type:s.type,location:e.getAttribLocation(t,o),locationSize:a}}return n}function Yc(e){return e!==""}function Tb(e,t){let n=t.numSpotLightShadows+t.numSpotLightMaps-t.numSpotLightShadowsWithMaps;return e.replace(/NUM_SUN_LIGHTS/g,t.numSunLights).replace(/NUM_DIR_LIGHTS/g,t.numDirLights).replace(/NUM_SPOT_LIGHTS/g,t.numSpotLights).replace(/NUM_SPOT_LIGHT_MAPS/g,t.numSpotLightMaps).replace(/NUM_SPOT_LIGHT_COORDS/g,n).replace(/NUM_RECT_AREA_LIGHTS/g,t.numRectAreaLights).replace(/NUM_POINT_LIGHTS/g,t.numPointLights).replace(/NUM_HEMI_LIGHTS/g,t.numHemiLights).replace(/NUM_SUN_LIGHT_SHADOWS/g,t.numSunLightShadows).replace(/NUM_DIR_LIGHT_SHADOWS/g,t.numDirLightShadows).replace(/NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS/g,t.numSpotLightShadowsWithMaps).replace(/NUM_SPOT_LIGHT_SHADOWS/g,t.numSpotLightShadows).replace(/NUM_POINT_LIGHT_SHADOWS/g,t.numPointLightShadows).replace(/NUM_LIGHT_PROBE_GRIDS/g,t.numLightProbeGrids)}function Ab(e,t){return e.replace(/NUM_CLIPPING_PLANES/g,t.numClippingPlanes).replace(/UNION_CLIPPING_PLANES/g,t.numClippingPlanes-t.numClipIntersection)}var IL=/^[ \t]*#include +<([\w\d./]+)>/gm;function Fm(e){return e.replace(IL,PL)}function PL(e,t){let n=Jt[t];if(n===void 0)throw new Error("THREE.WebGLProgram: Can not resolve #include <"+t+">");return Fm(n)}var LL=/#pragma unroll_loop_start\s+for\s*\(\s*int\s+i\s*=\s*(\d+)\s*;\s*i\s*<\s*(\d+)\s*;\s*i\s*\+\+\s*\)\s*{([\s\S]+?)}\s+#pragma unroll_loop_end/g;function Eb(e){return e.replace(LL,NL)}function NL(e,t,n,i){let r="";for(let s=parseInt(t);s<parseInt(n);s++)r+=i.replace(/\[\s*i\s*\]/g,"[ "+s+" ]").replace(/UNROLLED_LOOP_INDEX/g,s);return r}function Cb(e){let t=`precision ${e.precision} float;
	precision ${e.precision} int;
	precision ${e.precision} sampler2D;
	precision ${e.precision} samplerCube;
	precision ${e.precision} sampler3D;
	precision ${e.precision} sampler2DArray;
	precision ${e.precision} sampler2DShadow;
	precision ${e.precision} samplerCubeShadow;
	precision ${e.precision} sampler2DArrayShadow;
	precision ${e.precision} isampler2D;
	precision ${e.precision} isampler3D;
	precision ${e.precision} isamplerCube;
	precision ${e.precision} isampler2DArray;
	precision ${e.precision} usampler2D;
	precision ${e.precision} usampler3D;
	precision ${e.precision} usamplerCube;
	precision ${e.precision} usampler2DArray;
	`;return e.precision==="highp"?t+=`
#define HIGH_PRECISION`:e.precision==="mediump"?t+=`
#define MEDIUM_PRECISION`:e.precision==="lowp"&&(t+=`
#define LOW_PRECISION`),t}var DL={[kc]:"SHADOWMAP_TYPE_PCF",[na]:"SHADOWMAP_TYPE_VSM"};function FL(e){return DL[e.shadowMapType]||"SHADOWMAP_TYPE_BASIC"}var UL={[ra]:"ENVMAP_MODE_REFRACTION"};function OL(e){return e.envMap===!1?"ENVMAP_MODE_REFLECTION":UL[e.envMapMode]||"ENVMAP_MODE_REFLECTION"}var BL={[hf]:"ENVMAP_BLENDING_MULTIPLY",[Wv]:"ENVMAP_BLENDING_MIX",[$v]:"ENVMAP_BLENDING_ADD"};function kL(e){return e.envMap===!1?"ENVMAP_BLENDING_NONE":BL[e.combine]||"ENVMAP_BLENDING_NONE"}function zL(e,t,n,i){let r=e.getContext(),s=n.defines,o=n.vertexShader,a=n.fragmentShader,c=FL(n),l=n.envMapPMREM===!0?"ENVMAP_TYPE_PMREM":"ENVMAP_TYPE_CUBE",u=OL(n),h=kL(n),f=EL(n),d=CL(s),p=r.createProgram(),y,m,g=n.glslVersion?"#version "+n.glslVersion+`
`:"";n.isRawShaderMaterial?(y=["#define SHADER_TYPE "+n.shaderType,"#define SHADER_NAME "+n.shaderName,d].filter(Yc).join(`
`),y.length>0&&(y+=`
`),m=["#define SHADER_TYPE "+n.shaderType,"#define SHADER_NAME "+n.shaderName,d].filter(Yc).join(`
`),m.length>0&&(m+=`
`)):(y=[Cb(n),"#define SHADER_TYPE "+n.shaderType,"#define SHADER_NAME "+n.shaderName,d,n.extensionClipCullDistance?"#define USE_CLIP_DISTANCE":"",n.batching?"#define USE_BATCHING":"",n.batchingColor?"#define USE_BATCHING_COLOR":"",n.instancing?"#define USE_INSTANCING":"",n.instancingColor?"#define USE_INSTANCING_COLOR":"",n.instancingMorph?"#define USE_INSTANCING_MORPH":"",n.useFog&&n.fog?"#define USE_FOG":"",n.useFog&&n.fogExp2?"#define FOG_EXP2":"",n.map?"#define USE_MAP":"",n.envMap?"#define USE_ENVMAP":"",n.envMap?"#define "+u:"",n.lightMap?"#define USE_LIGHTMAP":"",n.aoMap?"#define USE_AOMAP":"",n.bumpMap?"#define USE_BUMPMAP":"",n.normalMap?"#define USE_NORMALMAP":"",n.normalMapObjectSpace?"#define USE_NORMALMAP_OBJECTSPACE":"",n.normalMapTangentSpace?"#define USE_NORMALMAP_TANGENTSPACE":"",n.displacementMap?"#define USE_DISPLACEMENTMAP":"",n.emissiveMap?"#define USE_EMISSIVEMAP":"",n.anisotropy?"#define USE_ANISOTROPY":"",n.anisotropyMap?"#define USE_ANISOTROPYMAP":"",n.clearcoatMap?"#define USE_CLEARCOATMAP":"",n.clearcoatRoughnessMap?"#define USE_CLEARCOAT_ROUGHNESSMAP":"",n.clearcoatNormalMap?"#define USE_CLEARCOAT_NORMALMAP":"",n.diffuseRoughnessMap?"#define USE_DIFFUSE_ROUGHNESSMAP":"",n.iridescenceMap?"#define USE_IRIDESCENCEMAP":"",n.iridescenceThicknessMap?"#define USE_IRIDESCENCE_THICKNESSMAP":"",n.specularMap?"#define USE_SPECULARMAP":"",n.specularColorMap?"#define USE_SPECULAR_COLORMAP":"",n.specularIntensityMap?"#define USE_SPECULAR_INTENSITYMAP":"",n.roughnessMap?"#define USE_ROUGHNESSMAP":"",n.metalnessMap?"#define USE_METALNESSMAP":"",n.alphaMap?"#define USE_ALPHAMAP":"",n.alphaHash?"#define USE_ALPHAHASH":"",n.transmission?"#define USE_TRANSMISSION":"",n.transmissionMap?"#define USE_TRANSMISSIONMAP":"",n.thicknessMap?"#define USE_THICKNESSMAP":"",n.sheenColorMap?"#define USE_SHEEN_COLORMAP":"",n.sheenRoughnessMap?"#define USE_SHEEN_ROUGHNESSMAP":"",n.mapUv?"#define MAP_UV "+n.mapUv:"",n.alphaMapUv?"#define ALPHAMAP_UV "+n.alphaMapUv:"",n.lightMapUv?"#define LIGHTMAP_UV "+n.lightMapUv:"",n.aoMapUv?"#define AOMAP_UV "+n.aoMapUv:"",n.emissiveMapUv?"#define EMISSIVEMAP_UV "+n.emissiveMapUv:"",n.bumpMapUv?"#define BUMPMAP_UV "+n.bumpMapUv:"",n.normalMapUv?"#define NORMALMAP_UV "+n.normalMapUv:"",n.displacementMapUv?"#define DISPLACEMENTMAP_UV "+n.displacementMapUv:"",n.metalnessMapUv?"#define METALNESSMAP_UV "+n.metalnessMapUv:"",n.roughnessMapUv?"#define ROUGHNESSMAP_UV "+n.roughnessMapUv:"",n.anisotropyMapUv?"#define ANISOTROPYMAP_UV "+n.anisotropyMapUv:"",n.clearcoatMapUv?"#define CLEARCOATMAP_UV "+n.clearcoatMapUv:"",n.clearcoatNormalMapUv?"#define CLEARCOAT_NORMALMAP_UV "+n.clearcoatNormalMapUv:"",n.clearcoatRoughnessMapUv?"#define CLEARCOAT_ROUGHNESSMAP_UV "+n.clearcoatRoughnessMapUv:"",n.diffuseRoughnessMapUv?"#define DIFFUSE_ROUGHNESSMAP_UV "+n.diffuseRoughnessMapUv:"",n.iridescenceMapUv?"#define IRIDESCENCEMAP_UV "+n.iridescenceMapUv:"",n.iridescenceThicknessMapUv?"#define IRIDESCENCE_THICKNESSMAP_UV "+n.iridescenceThicknessMapUv:"",n.sheenColorMapUv?"#define SHEEN_COLORMAP_UV "+n.sheenColorMapUv:"",n.sheenRoughnessMapUv?"#define SHEEN_ROUGHNESSMAP_UV "+n.sheenRoughnessMapUv:"",n.specularMapUv?"#define SPECULARMAP_UV "+n.specularMapUv:"",n.specularColorMapUv?"#define SPECULAR_COLORMAP_UV "+n.specularColorMapUv:"",n.specularIntensityMapUv?"#define SPECULAR_INTENSITYMAP_UV "+n.specularIntensityMapUv:"",n.transmissionMapUv?"#define TRANSMISSIONMAP_UV "+n.transmissionMapUv:"",n.thicknessMapUv?"#define THICKNESSMAP_UV "+n.thicknessMapUv:"",n.vertexTangents&&n.flatShading===!1?"#define USE_TANGENT":"",n.vertexNormals?"#define HAS_NORMAL":"",n.vertexColors?"#define USE_COLOR":"",n.vertexAlphas?"#define USE_COLOR_ALPHA":"",n.vertexUv1s?"#define USE_UV1":"",n.vertexUv2s?"#define USE_UV2":"",n.vertexUv3s?"#define USE_UV3":"",n.pointsUvs?"#define USE_POINTS_UV":"",n.flatShading?"#define FLAT_SHADED":"",n.skinning?"#define USE_SKINNING":"",n.morphTargets?"#define USE_MORPHTARGETS":"",n.morphNormals&&n.flatShading===!1?"#define USE_MORPHNORMALS":"",n.morphColors?"#define USE_MORPHCOLORS":"",n.morphTargetsCount>0?"#define MORPHTARGETS_TEXTURE_STRIDE "+n.morphTextureStride:"",n.morphTargetsCount>0?"#define MORPHTARGETS_COUNT "+n.morphTargetsCount:"",n.doubleSided?"#define DOUBLE_SIDED":"",n.flipSided?"#define FLIP_SIDED":"",n.shadowMapEnabled?"#define USE_SHADOWMAP":"",n.shadowMapEnabled?"#define "+c:"",n.sizeAttenuation?"#define USE_SIZEATTENUATION":"",n.numLightProbes>0?"#define USE_LIGHT_PROBES":"",n.logarithmicDepthBuffer?"#define USE_LOGARITHMIC_DEPTH_BUFFER":"",n.reversedDepthBuffer?"#define USE_REVERSED_DEPTH_BUFFER":"","uniform mat4 modelMatrix;","uniform mat4 modelViewMatrix;","uniform mat4 projectionMatrix;","uniform mat4 viewMatrix;","uniform mat3 normalMatrix;","uniform vec3 cameraPosition;","uniform bool isOrthographic;","#ifdef USE_INSTANCING","	attribute mat4 instanceMatrix;","#endif","#ifdef USE_INSTANCING_COLOR","	attribute vec3 instanceColor;","#endif","#ifdef USE_INSTANCING_MORPH","	uniform sampler2D morphTexture;","#endif","attribute vec3 position;","attribute vec3 normal;","attribute vec2 uv;","#ifdef USE_UV1","	attribute vec2 uv1;","#endif","#ifdef USE_UV2","	attribute vec2 uv2;","#endif","#ifdef USE_UV3","	attribute vec2 uv3;","#endif","#ifdef USE_TANGENT","	attribute vec4 tangent;","#endif","#if defined( USE_COLOR_ALPHA )","	attribute vec4 color;","#elif defined( USE_COLOR )","	attribute vec3 color;","#endif","#ifdef USE_SKINNING","	attribute vec4 skinIndex;","	attribute vec4 skinWeight;","#endif",`
`].filter(Yc).join(`
`),m=[Cb(n),"#define SHADER_TYPE "+n.shaderType,"#define SHADER_NAME "+n.shaderName,d,n.useFog&&n.fog?"#define USE_FOG":"",n.useFog&&n.fogExp2?"#define FOG_EXP2":"",n.alphaToCoverage?"#define ALPHA_TO_COVERAGE":"",n.map?"#define USE_MAP":"",n.matcap?"#define USE_MATCAP":"",n.envMap?"#define USE_ENVMAP":"",n.envMap?"#define "+l:"",n.envMap?"#define "+u:"",n.envMap?"#define "+h:"",n.envMapPMREM?"#define ENVMAP_MAX_LOD "+n.envMapMaxLod+".0":"",n.envMapPMREM?"#define ENVMAP_SIZE "+n.envMapSize+".0":"",n.lightMap?"#define USE_LIGHTMAP":"",n.aoMap?"#define USE_AOMAP":"",n.bumpMap?"#define USE_BUMPMAP":"",n.normalMap?"#define USE_NORMALMAP":"",n.normalMapObjectSpace?"#define USE_NORMALMAP_OBJECTSPACE":"",n.normalMapTangentSpace?"#define USE_NORMALMAP_TANGENTSPACE":"",n.packedNormalMap?"#define USE_PACKED_NORMALMAP":"",n.emissiveMap?"#define USE_EMISSIVEMAP":"",n.anisotropy?"#define USE_ANISOTROPY":"",n.anisotropyMap?"#define USE_ANISOTROPYMAP":"",n.clearcoat?"#define USE_CLEARCOAT":"",n.clearcoatMap?"#define USE_CLEARCOATMAP":"",n.clearcoatRoughnessMap?"#define USE_CLEARCOAT_ROUGHNESSMAP":"",n.clearcoatNormalMap?"#define USE_CLEARCOAT_NORMALMAP":"",n.diffuseRoughness?"#define USE_DIFFUSE_ROUGHNESS":"",n.diffuseRoughnessMap?"#define USE_DIFFUSE_ROUGHNESSMAP":"",n.dispersion?"#define USE_DISPERSION":"",n.retroreflection?"#define USE_RETROREFLECTION":"",n.iridescence?"#define USE_IRIDESCENCE":"",n.iridescenceMap?"#define USE_IRIDESCENCEMAP":"",n.iridescenceThicknessMap?"#define USE_IRIDESCENCE_THICKNESSMAP":"",n.specularMap?"#define USE_SPECULARMAP":"",n.specularColorMap?"#define USE_SPECULAR_COLORMAP":"",n.specularIntensityMap?"#define USE_SPECULAR_INTENSITYMAP":"",n.roughnessMap?"#define USE_ROUGHNESSMAP":"",n.metalnessMap?"#define USE_METALNESSMAP":"",n.alphaMap?"#define USE_ALPHAMAP":"",n.alphaTest?"#define USE_ALPHATEST":"",n.alphaHash?"#define USE_ALPHAHASH":"",n.sheen?"#define USE_SHEEN":"",n.sheenColorMap?"#define USE_SHEEN_COLORMAP":"",n.sheenRoughnessMap?"#define USE_SHEEN_ROUGHNESSMAP":"",n.transmission?"#define USE_TRANSMISSION":"",n.transmissionMap?"#define USE_TRANSMISSIONMAP":"",n.thicknessMap?"#define USE_THICKNESSMAP":"",n.vertexTangents&&n.flatShading===!1?"#define USE_TANGENT":"",n.vertexColors||n.instancingColor?"#define USE_COLOR":"",n.vertexAlphas||n.batchingColor?"#define USE_COLOR_ALPHA":"",n.vertexUv1s?"#define USE_UV1":"",n.vertexUv2s?"#define USE_UV2":"",n.vertexUv3s?"#define USE_UV3":"",n.pointsUvs?"#define USE_POINTS_UV":"",n.gradientMap?"#define USE_GRADIENTMAP":"",n.flatShading?"#define FLAT_SHADED":"",n.doubleSided?"#define DOUBLE_SIDED":"",n.flipSided?"#define FLIP_SIDED":"",n.shadowMapEnabled?"#define USE_SHADOWMAP":"",n.shadowMapEnabled?"#define "+c:"",n.premultipliedAlpha?"#define PREMULTIPLIED_ALPHA":"",n.numLightProbes>0?"#define USE_LIGHT_PROBES":"",n.decodeVideoTexture?"#define DECODE_VIDEO_TEXTURE":"",n.decodeVideoTextureEmissive?"#define DECODE_VIDEO_TEXTURE_EMISSIVE":"",n.logarithmicDepthBuffer?"#define USE_LOGARITHMIC_DEPTH_BUFFER":"",n.reversedDepthBuffer?"#define USE_REVERSED_DEPTH_BUFFER":"","uniform mat4 viewMatrix;","uniform vec3 cameraPosition;","uniform bool isOrthographic;",n.toneMapping!==Yi?"#define TONE_MAPPING":"",n.toneMapping!==Yi?Jt.tonemapping_pars_fragment:"",n.toneMapping!==Yi?TL("toneMapping",n.toneMapping):"",n.dithering?"#define DITHERING":"",n.opaque?"#define OPAQUE":"",Jt.colorspace_pars_fragment,SL("linearToOutputTexel",n.outputColorSpace),AL(),n.useDepthPacking?"#define DEPTH_PACKING "+n.depthPacking:"",`
`].filter(Yc).join(`
`)),o=Fm(o),o=Tb(o,n),o=Ab(o,n),a=Fm(a),a=Tb(a,n),a=Ab(a,n),o=Eb(o),a=Eb(a),n.isRawShaderMaterial!==!0&&(g=`#version 300 es
`,y=[f,"#define attribute in","#define varying out","#define texture2D texture"].join(`
`)+`
`+y,m=["#define varying in",n.glslVersion===vm?"":"layout(location = 0) out highp vec4 pc_fragColor;",n.glslVersion===vm?"":"#define gl_FragColor pc_fragColor","#define gl_FragDepthEXT gl_FragDepth","#define texture2D texture","#define textureCube texture","#define texture2DProj textureProj","#define texture2DLodEXT textureLod","#define texture2DProjLodEXT textureProjLod","#define textureCubeLodEXT textureLod","#define texture2DGradEXT textureGrad","#define texture2DProjGradEXT textureProjGrad","#define textureCubeGradEXT textureGrad"].join(`
`)+`
`+m);let v=g+y+o,S=g+m+a,_=Mb(r,r.VERTEX_SHADER,v),w=Mb(r,r.FRAGMENT_SHADER,S);r.attachShader(p,_),r.attachShader(p,w),n.index0AttributeName!==void 0?r.bindAttribLocation(p,0,n.index0AttributeName):n.hasPositionAttribute===!0&&r.bindAttribLocation(p,0,"position"),r.linkProgram(p);function b(E){if(e.debug.checkShaderErrors){let C=r.getProgramInfoLog(p)||"",N=r.getShaderInfoLog(_)||"",B=r.getShaderInfoLog(w)||"",I=C.trim(),L=N.trim(),k=B.trim(),F=!0,Z=!0;if(r.getProgramParameter(p,r.LINK_STATUS)===!1)if(F=!1,typeof e.debug.onShaderError=="function")e.debug.onShaderError(r,p,_,w);else{let U=wb(r,_,"vertex"),G=wb(r,w,"fragment");kt("WebGLProgram: Shader Error "+r.getError()+" - VALIDATE_STATUS "+r.getProgramParameter(p,r.VALIDATE_STATUS)+`

Material Name: `+E.name+`
Material Type: `+E.type+`

Program Info Log: `+I+`
`+U+`
`+G)}else I!==""?Ft("WebGLProgram: Program Info Log:",I):(L===""||k==="")&&(Z=!1);Z&&(E.diagnostics={runnable:F,programLog:I,vertexShader:{log:L,prefix:y},fragmentShader:{log:k,prefix:m}})}r.deleteShader(_),r.deleteShader(w),x=new aa(r,p),M=RL(r,p)}let x;this.getUniforms=function(){return x===void 0&&b(this),x};let M;this.getAttributes=function(){return M===void 0&&b(this),M};let R=n.rendererExtensionParallelShaderCompile===!1;return this.isReady=function(){return R===!1&&(R=r.getProgramParameter(p,_L)),R},this.destroy=function(){i.releaseStatesOfProgram(this),r.deleteProgram(p),this.program=void 0},this.type=n.shaderType,this.name=n.shaderName,this.id=vL++,this.cacheKey=t,this.usedTimes=1,this.program=p,this.vertexShader=_,this.fragmentShader=w,this}var GL=0,Um=class{constructor(){this.shaderCache=new Map,this.materialCache=new Map}update(t,n,i){let r=this._getShaderCacheForMaterial(t);return r.has(n)===!1&&(r.add(n),n.usedTimes++),r.has(i)===!1&&(r.add(i),i.usedTimes++),this}remove(t){let n=this.materialCache.get(t);for(let i of n)i.usedTimes--,i.usedTimes===0&&this.shaderCache.delete(i.code);return this.materialCache.delete(t),this}getVertexShaderStage(t){return this._getShaderStage(t.vertexShader)}getFragmentShaderStage(t){return this._getShaderStage(t.fragmentShader)}dispose(){this.shaderCache.clear(),this.materialCache.clear()}_getShaderCacheForMaterial(t){let n=this.materialCache,i=n.get(t);return i===void 0&&(i=new Set,n.set(t,i)),i}_getShaderStage(t){let n=this.shaderCache,i=n.get(t);return i===void 0&&(i=new Om(t),n.set(t,i)),i}},Om=class{constructor(t){this.id=GL++,this.code=t,this.usedTimes=0}};function VL(e){return e===xs||e===$c||e===Xc}function HL(e,t,n,i,r,s){let o=new wc,a=new Um,c=new Set,l=[],u=new Map,h=i.logarithmicDepthBuffer,f={MeshDepthMaterial:"depth",MeshDistanceMaterial:"distance",MeshNormalMaterial:"normal",MeshBasicMaterial:"basic",MeshLambertMaterial:"lambert",MeshPhongMaterial:"phong",MeshToonMaterial:"toon",MeshStandardMaterial:"physical",MeshPhysicalMaterial:"physical",MeshMatcapMaterial:"matcap",LineBasicMaterial:"basic",LineDashedMaterial:"dashed",PointsMaterial:"points",ShadowMaterial:"shadow",SpriteMaterial:"sprite"};function d(x){return c.add(x),x===0?"uv":`uv${x}`}function p(x,M,R,E,C,N){let B=E.fog,I=C.geometry,L=x.isMeshStandardMaterial||x.isMeshLambertMaterial||x.isMeshPhongMaterial?E.environment:null,k=x.isMeshStandardMaterial||x.isMeshLambertMaterial&&!x.envMap||x.isMeshPhongMaterial&&!x.envMap,F=t.get(x.envMap||L,k),Z=f[x.type],U=i.precision;x.precision!==null&&(U=i.getMaxPrecision(x.precision),U!==x.precision&&Ft("WebGLProgram.getParameters:",x.precision,"not supported, using",U,"instead."));let G=I.morphAttributes.position||I.morphAttributes.normal||I.morphAttributes.color,q=G!==void 0?G.length:0,st=0;I.morphAttributes.position!==void 0&&(st=1),I.morphAttributes.normal!==void 0&&(st=2),I.morphAttributes.color!==void 0&&(st=3);let ct,$,at,ft;if(Z){let wt=Ji[Z];ct=wt.vertexShader,$=wt.fragmentShader}else{ct=x.vertexShader,$=x.fragmentShader;let wt=a.getVertexShaderStage(x),he=a.getFragmentShaderStage(x);a.update(x,wt,he),at=wt.id,ft=he.id}let ot=e.getRenderTarget(),rt=e.state.buffers.depth.getReversed(),J=C.isInstancedMesh===!0,gt=C.isBatchedMesh===!0,lt=!!x.map,K=!!x.matcap,It=!!F,pt=It&&F.isPMREMTexture===!0,Ut=!!x.aoMap,Gt=!!x.lightMap,ce=!!x.bumpMap&&x.wireframe===!1,oe=!!x.normalMap,Xe=!!x.displacementMap,Be=!!x.emissiveMap,Ln=!!x.metalnessMap,xn=!!x.roughnessMap,Nn=x.anisotropy>0,z=x.clearcoat>0,Dn=x.diffuseRoughness>0,_e=x.dispersion>0,ve=x.retroreflectivity>0,mt=x.iridescence>0,Ce=x.sheen>0,Lt=x.transmission>0,Bt=Nn&&!!x.anisotropyMap,P=z&&!!x.clearcoatMap,T=z&&!!x.clearcoatNormalMap,V=z&&!!x.clearcoatRoughnessMap,ut=Dn&&!!x.diffuseRoughnessMap,nt=mt&&!!x.iridescenceMap,yt=mt&&!!x.iridescenceThicknessMap,Mt=Ce&&!!x.sheenColorMap,Q=Ce&&!!x.sheenRoughnessMap,tt=!!x.specularMap,_t=!!x.specularColorMap,D=!!x.specularIntensityMap,et=Lt&&!!x.transmissionMap,j=Lt&&!!x.thicknessMap,vt=!!x.gradientMap,dt=!!x.alphaMap,xt=x.alphaTest>0,Nt=!!x.alphaHash,Yt=!!x.extensions,ht=Yi;x.toneMapped&&(ot===null||ot.isXRRenderTarget===!0)&&(ht=e.toneMapping);let Dt=pt?F.isCompressedCubeTexture?F.image[0].mipmaps:F.mipmaps:null,qt={shaderID:Z,shaderType:x.type,shaderName:x.name,vertexShader:ct,fragmentShader:$,defines:x.defines,customVertexShaderID:at,customFragmentShaderID:ft,isRawShaderMaterial:x.isRawShaderMaterial===!0,glslVersion:x.glslVersion,precision:U,batching:gt,batchingColor:gt&&C._colorsTexture!==null,instancing:J,instancingColor:J&&C.instanceColor!==null,instancingMorph:J&&C.morphTexture!==null,outputColorSpace:ot===null?e.outputColorSpace:ot.isXRRenderTarget===!0?ot.texture.colorSpace:ee.workingColorSpace,alphaToCoverage:!!x.alphaToCoverage,map:lt,matcap:K,envMap:It,envMapMode:It&&F.mapping,envMapPMREM:pt,envMapMaxLod:pt?Dt.length-1:null,envMapSize:pt?Dt[0].width:null,aoMap:Ut,lightMap:Gt,bumpMap:ce,normalMap:oe,displacementMap:Xe,emissiveMap:Be,normalMapObjectSpace:oe&&x.normalMapType===Yv,normalMapTangentSpace:oe&&x.normalMapType===jf,packedNormalMap:oe&&x.normalMapType===jf&&VL(x.normalMap.format),metalnessMap:Ln,roughnessMap:xn,anisotropy:Nn,anisotropyMap:Bt,clearcoat:z,clearcoatMap:P,clearcoatNormalMap:T,clearcoatRoughnessMap:V,diffuseRoughness:Dn,diffuseRoughnessMap:ut,dispersion:_e,retroreflection:ve,iridescence:mt,iridescenceMap:nt,iridescenceThicknessMap:yt,sheen:Ce,sheenColorMap:Mt,sheenRoughnessMap:Q,specularMap:tt,specularColorMap:_t,specularIntensityMap:D,transmission:Lt,transmissionMap:et,thicknessMap:j,gradientMap:vt,opaque:x.transparent===!1&&x.blending===ia&&x.alphaToCoverage===!1,alphaMap:dt,alphaTest:xt,alphaHash:Nt,combine:x.combine,mapUv:lt&&d(x.map.channel),aoMapUv:Ut&&d(x.aoMap.channel),lightMapUv:Gt&&d(x.lightMap.channel),bumpMapUv:ce&&d(x.bumpMap.channel),normalMapUv:oe&&d(x.normalMap.channel),displacementMapUv:Xe&&d(x.displacementMap.channel),emissiveMapUv:Be&&d(x.emissiveMap.channel),metalnessMapUv:Ln&&d(x.metalnessMap.channel),roughnessMapUv:xn&&d(x.roughnessMap.channel),anisotropyMapUv:Bt&&d(x.anisotropyMap.channel),clearcoatMapUv:P&&d(x.clearcoatMap.channel),clearcoatNormalMapUv:T&&d(x.clearcoatNormalMap.channel),clearcoatRoughnessMapUv:V&&d(x.clearcoatRoughnessMap.channel),diffuseRoughnessMapUv:ut&&d(x.diffuseRoughnessMap.channel),iridescenceMapUv:nt&&d(x.iridescenceMap.channel),iridescenceThicknessMapUv:yt&&d(x.iridescenceThicknessMap.channel),sheenColorMapUv:Mt&&d(x.sheenColorMap.channel),sheenRoughnessMapUv:Q&&d(x.sheenRoughnessMap.channel),specularMapUv:tt&&d(x.specularMap.channel),specularColorMapUv:_t&&d(x.specularColorMap.channel),specularIntensityMapUv:D&&d(x.specularIntensityMap.channel),transmissionMapUv:et&&d(x.transmissionMap.channel),thicknessMapUv:j&&d(x.thicknessMap.channel),alphaMapUv:dt&&d(x.alphaMap.channel),vertexTangents:!!I.attributes.tangent&&(oe||Nn),vertexNormals:!!I.attributes.normal,vertexColors:x.vertexColors,vertexAlphas:x.vertexColors===!0&&!!I.attributes.color&&I.attributes.color.itemSize===4,pointsUvs:C.isPoints===!0&&!!I.attributes.uv&&(lt||dt),fog:!!B,useFog:x.fog===!0,fogExp2:!!B&&B.isFogExp2,flatShading:x.wireframe===!1&&(x.flatShading===!0||I.attributes.normal===void 0&&oe===!1&&(x.isMeshLambertMaterial||x.isMeshPhongMaterial||x.isMeshStandardMaterial||x.isMeshPhysicalMaterial)),sizeAttenuation:x.sizeAttenuation===!0,logarithmicDepthBuffer:h,reversedDepthBuffer:rt,skinning:C.isSkinnedMesh===!0,hasPositionAttribute:I.attributes.position!==void 0,morphTargets:I.morphAttributes.position!==void 0,morphNormals:I.morphAttributes.normal!==void 0,morphColors:I.morphAttributes.color!==void 0,morphTargetsCount:q,morphTextureStride:st,numSunLights:M.sun.length,numDirLights:M.directional.length,numPointLights:M.point.length,numSpotLights:M.spot.length,numSpotLightMaps:M.spotLightMap.length,numRectAreaLights:M.rectArea.length,numHemiLights:M.hemi.length,numSunLightShadows:M.sunShadowMap.length,numDirLightShadows:M.directionalShadowMap.length,numPointLightShadows:M.pointShadowMap.length,numSpotLightShadows:M.spotShadowMap.length,numSpotLightShadowsWithMaps:M.numSpotLightShadowsWithMaps,numLightProbes:M.numLightProbes,numLightProbeGrids:N.filter(wt=>wt.texture!==null).length,numClippingPlanes:s.numPlanes,numClipIntersection:s.numIntersection,dithering:x.dithering,shadowMapEnabled:e.shadowMap.enabled&&R.length>0,shadowMapType:e.shadowMap.type,toneMapping:ht,decodeVideoTexture:lt&&x.map.isVideoTexture===!0&&ee.getTransfer(x.map.colorSpace)===ue,decodeVideoTextureEmissive:Be&&x.emissiveMap.isVideoTexture===!0&&ee.getTransfer(x.emissiveMap.colorSpace)===ue,premultipliedAlpha:x.premultipliedAlpha,doubleSided:x.side===si,flipSided:x.side===Tn,useDepthPacking:x.depthPacking>=0,depthPacking:x.depthPacking||0,index0AttributeName:x.index0AttributeName,extensionClipCullDistance:Yt&&x.extensions.clipCullDistance===!0&&n.has("WEBGL_clip_cull_distance"),extensionMultiDraw:(Yt&&x.extensions.multiDraw===!0||gt)&&n.has("WEBGL_multi_draw"),rendererExtensionParallelShaderCompile:n.has("KHR_parallel_shader_compile"),customProgramCacheKey:x.customProgramCacheKey()};return qt.vertexUv1s=c.has(1),qt.vertexUv2s=c.has(2),qt.vertexUv3s=c.has(3),c.clear(),qt}function y(x){let M=[];if(x.shaderID?M.push(x.shaderID):(M.push(x.customVertexShaderID),M.push(x.customFragmentShaderID)),x.defines!==void 0)for(let R in x.defines)M.push(R),M.push(x.defines[R]);return x.isRawShaderMaterial===!1&&(m(M,x),g(M,x),M.push(e.outputColorSpace)),M.push(x.customProgramCacheKey),M.join()}function m(x,M){x.push(M.precision),x.push(M.outputColorSpace),x.push(M.envMapMode),x.push(M.envMapPMREM),x.push(M.envMapMaxLod),x.push(M.envMapSize),x.push(M.mapUv),x.push(M.alphaMapUv),x.push(M.lightMapUv),x.push(M.aoMapUv),x.push(M.bumpMapUv),x.push(M.normalMapUv),x.push(M.displacementMapUv),x.push(M.emissiveMapUv),x.push(M.metalnessMapUv),x.push(M.roughnessMapUv),x.push(M.anisotropyMapUv),x.push(M.clearcoatMapUv),x.push(M.clearcoatNormalMapUv),x.push(M.clearcoatRoughnessMapUv),x.push(M.diffuseRoughnessMapUv),x.push(M.iridescenceMapUv),x.push(M.iridescenceThicknessMapUv),x.push(M.sheenColorMapUv),x.push(M.sheenRoughnessMapUv),x.push(M.specularMapUv),x.push(M.specularColorMapUv),x.push(M.specularIntensityMapUv),x.push(M.transmissionMapUv),x.push(M.thicknessMapUv),x.push(M.combine),x.push(M.fogExp2),x.push(M.sizeAttenuation),x.push(M.morphTargetsCount),x.push(M.numSunLights),x.push(M.numDirLights),x.push(M.numPointLights),x.push(M.numSpotLights),x.push(M.numSpotLightMaps),x.push(M.numHemiLights),x.push(M.numRectAreaLights),x.push(M.numSunLightShadows),x.push(M.numDirLightShadows),x.push(M.numPointLightShadows),x.push(M.numSpotLightShadows),x.push(M.numSpotLightShadowsWithMaps),x.push(M.numLightProbes),x.push(M.numLightProbeGrids),x.push(M.shadowMapType),x.push(M.toneMapping),x.push(M.numClippingPlanes),x.push(M.numClipIntersection),x.push(M.depthPacking)}function g(x,M){o.disableAll(),M.instancing&&o.enable(0),M.instancingColor&&o.enable(1),M.instancingMorph&&o.enable(2),M.matcap&&o.enable(3),M.envMap&&o.enable(4),M.normalMapObjectSpace&&o.enable(5),M.normalMapTangentSpace&&o.enable(6),M.clearcoat&&o.enable(7),M.iridescence&&o.enable(8),M.alphaTest&&o.enable(9),M.vertexColors&&o.enable(10),M.vertexAlphas&&o.enable(11),M.vertexUv1s&&o.enable(12),M.vertexUv2s&&o.enable(13),M.vertexUv3s&&o.enable(14),M.vertexTangents&&o.enable(15),M.anisotropy&&o.enable(16),M.alphaHash&&o.enable(17),M.batching&&o.enable(18),M.dispersion&&o.enable(19),M.retroreflection&&o.enable(24),M.diffuseRoughness&&o.enable(25),M.batchingColor&&o.enable(20),M.gradientMap&&o.enable(21),M.packedNormalMap&&o.enable(22),M.vertexNormals&&o.enable(23),x.push(o.mask),o.disableAll(),M.fog&&o.enable(0),M.useFog&&o.enable(1),M.flatShading&&o.enable(2),M.logarithmicDepthBuffer&&o.enable(3),M.reversedDepthBuffer&&o.enable(4),M.skinning&&o.enable(5),M.morphTargets&&o.enable(6),M.morphNormals&&o.enable(7),M.morphColors&&o.enable(8),M.premultipliedAlpha&&o.enable(9),M.shadowMapEnabled&&o.enable(10),M.doubleSided&&o.enable(11),M.flipSided&&o.enable(12),M.useDepthPacking&&o.enable(13),M.dithering&&o.enable(14),M.transmission&&o.enable(15),M.sheen&&o.enable(16),M.opaque&&o.enable(17),M.pointsUvs&&o.enable(18),M.decodeVideoTexture&&o.enable(19),M.decodeVideoTextureEmissive&&o.enable(20),M.alphaToCoverage&&o.enable(21),M.numLightProbeGrids>0&&o.enable(22),M.hasPositionAttribute&&o.enable(23),x.push(o.mask)}function v(x){let M=f[x.type],R;if(M){let E=Ji[M];R=lb.clone(E.uniforms)}else R=x.uniforms;return R}function S(x,M){let R=u.get(M);return R!==void 0?++R.usedTimes:(R=new zL(e,M,x,r),l.push(R),u.set(M,R)),R}function _(x){if(--x.usedTimes===0){let M=l.indexOf(x);l[M]=l[l.length-1],l.pop(),u.delete(x.cacheKey),x.destroy()}}function w(x){a.remove(x)}function b(){a.dispose()}return{getParameters:p,getProgramCacheKey:y,getUniforms:v,acquireProgram:S,releaseProgram:_,releaseShaderCache:w,programs:l,dispose:b}}function WL(){let e=new WeakMap;function t(o){return e.has(o)}function n(o){let a=e.get(o);return a===void 0&&(a={},e.set(o,a)),a}function i(o){e.delete(o)}function r(o,a,c){e.get(o)[a]=c}function s(){e=new WeakMap}return{has:t,get:n,remove:i,update:r,dispose:s}}function $L(e,t){return e.groupOrder!==t.groupOrder?e.groupOrder-t.groupOrder:e.renderOrder!==t.renderOrder?e.renderOrder-t.renderOrder:e.material.id!==t.material.id?e.material.id-t.material.id:e.materialVariant!==t.materialVariant?e.materialVariant-t.materialVariant:e.z!==t.z?e.z-t.z:e.id-t.id}function Rb(e,t){return e.groupOrder!==t.groupOrder?e.groupOrder-t.groupOrder:e.renderOrder!==t.renderOrder?e.renderOrder-t.renderOrder:e.z!==t.z?t.z-e.z:e.id-t.id}function Ib(){let e=[],t=0,n=[],i=[],r=[];function s(){t=0,n.length=0,i.length=0,r.length=0}function o(f){let d=0;return f.isInstancedMesh&&(d+=2),f.isSkinnedMesh&&(d+=1),d}function a(f,d,p,y,m,g){let v=e[t];return v===void 0?(v={id:f.id,object:f,geometry:d,material:p,materialVariant:o(f),groupOrder:y,renderOrder:f.renderOrder,z:m,group:g},e[t]=v):(v.id=f.id,v.object=f,v.geometry=d,v.material=p,v.materialVariant=o(f),v.groupOrder=y,v.renderOrder=f.renderOrder,v.z=m,v.group=g),t++,v}function c(f,d,p,y,m,g,v){v.reversedDepth===!0&&(m=-m);let S=a(f,d,p,y,m,g);p.transmission>0?i.push(S):p.transparent===!0?r.push(S):n.push(S)}function l(f,d,p,y,m,g){let v=a(f,d,p,y,m,g);p.transmission>0?i.unshift(v):p.transparent===!0?r.unshift(v):n.unshift(v)}function u(f,d){n.length>1&&n.sort(f||$L),i.length>1&&i.sort(d||Rb),r.length>1&&r.sort(d||Rb)}function h(){for(let f=t,d=e.length;f<d;f++){let p=e[f];if(p.id===null)break;p.id=null,p.object=null,p.geometry=null,p.material=null,p.group=null}}return{opaque:n,transmissive:i,transparent:r,init:s,push:c,unshift:l,finish:h,sort:u}}function XL(){let e=new WeakMap;function t(i,r){let s=e.get(i),o;return s===void 0?(o=new Ib,e.set(i,[o])):r>=s.length?(o=new Ib,s.push(o)):o=s[r],o}function n(){e=new WeakMap}return{get:t,dispose:n}}function qL(){let e={};return{get:function(t){if(e[t.id]!==void 0)return e[t.id];let n;switch(t.type){case"SunLight":case"DirectionalLight":n={direction:new W,color:new Zt};break;case"SpotLight":n={position:new W,direction:new W,color:new Zt,distance:0,coneCos:0,penumbraCos:0,decay:0};break;case"PointLight":n={position:new W,color:new Zt,distance:0,decay:0};break;case"HemisphereLight":n={direction:new W,skyColor:new Zt,groundColor:new Zt};break;case"RectAreaLight":n={color:new Zt,position:new W,halfWidth:new W,halfHeight:new W};break}return e[t.id]=n,n}}}function YL(){let e={};return{get:function(t){if(e[t.id]!==void 0)return e[t.id];let n;switch(t.type){case"SunLight":case"DirectionalLight":n={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new ie};break;case"SpotLight":n={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new ie};break;case"PointLight":n={shadowIntensity:1,shadowBias:0,shadowNormalBias:0,shadowRadius:1,shadowMapSize:new ie,shadowCameraNear:1,shadowCameraFar:1e3};break}return e[t.id]=n,n}}}var ZL=0;function JL(e,t){return(t.castShadow?2:0)-(e.castShadow?2:0)+(t.map?1:0)-(e.map?1:0)}function KL(e){let t=new qL,n=YL(),i={version:0,hash:{sunLength:-1,directionalLength:-1,pointLength:-1,spotLength:-1,rectAreaLength:-1,hemiLength:-1,numSunShadows:-1,numDirectionalShadows:-1,numPointShadows:-1,numSpotShadows:-1,numSpotMaps:-1,numLightProbes:-1},ambient:[0,0,0],probe:[],sun:[],sunShadow:[],sunShadowMap:[],sunShadowMatrix:[],sunShadowCascade:[],directional:[],directionalShadow:[],directionalShadowMap:[],directionalShadowMatrix:[],spot:[],spotLightMap:[],spotShadow:[],spotShadowMap:[],spotLightMatrix:[],rectArea:[],rectAreaLTC1:null,rectAreaLTC2:null,point:[],pointShadow:[],pointShadowMap:[],pointShadowMatrix:[],hemi:[],numSpotLightShadowsWithMaps:0,numLightProbes:0};for(let l=0;l<9;l++)i.probe.push(new W);let r=new W,s=new we,o=new we;function a(l){let u=0,h=0,f=0;for(let N=0;N<9;N++)i.probe[N].set(0,0,0);let d=0,p=0,y=0,m=0,g=0,v=0,S=0,_=0,w=0,b=0,x=0,M=0,R=0,E=0;l.sort(JL);for(let N=0,B=l.length;N<B;N++){let I=l[N],L=I.color,k=I.intensity,F=I.distance,Z=null;if(I.shadow&&I.shadow.map&&(I.shadow.map.texture.format===xs?Z=I.shadow.map.texture:Z=I.shadow.map.depthTexture||I.shadow.map.texture),I.isAmbientLight)u+=L.r*k,h+=L.g*k,f+=L.b*k;else if(I.isLightProbe){for(let U=0;U<9;U++)i.probe[U].addScaledVector(I.sh.coefficients[U],k);E++}else if(I.isSunLight){let U=t.get(I);if(U.color.copy(I.color).multiplyScalar(I.intensity),I.castShadow){let G=I.shadow,q=n.get(I);q.shadowIntensity=G.intensity,q.shadowBias=G.bias,q.shadowNormalBias=G.normalBias,q.shadowRadius=G.radius,q.shadowMapSize.copy(G.mapSize).multiply(G.getFrameExtents()),i.sunShadow[p]=q,i.sunShadowMap[p]=Z;let st=G.getViewportCount();for(let ct=0;ct<st;ct++)i.sunShadowMatrix[y+ct]=G.getMatrix(ct),i.sunShadowCascade[y+ct]=G._cascadeData[ct];y+=st,p++}i.sun[d]=U,d++}else if(I.isDirectionalLight){let U=t.get(I);if(U.color.copy(I.color).multiplyScalar(I.intensity),I.castShadow){let G=I.shadow,q=n.get(I);q.shadowIntensity=G.intensity,q.shadowBias=G.bias,q.shadowNormalBias=G.normalBias,q.shadowRadius=G.radius,q.shadowMapSize=G.mapSize,i.directionalShadow[m]=q,i.directionalShadowMap[m]=Z,i.directionalShadowMatrix[m]=I.shadow.matrix,w++}i.directional[m]=U,m++}else if(I.isSpotLight){let U=t.get(I);U.position.setFromMatrixPosition(I.matrixWorld),U.color.copy(L).multiplyScalar(k),U.distance=F,U.coneCos=Math.cos(I.angle),U.penumbraCos=Math.cos(I.angle*(1-I.penumbra)),U.decay=I.decay,i.spot[v]=U;let G=I.shadow;if(I.map&&(i.spotLightMap[M]=I.map,M++,G.updateMatrices(I),I.castShadow&&R++),i.spotLightMatrix[v]=G.matrix,I.castShadow){let q=n.get(I);q.shadowIntensity=G.intensity,q.shadowBias=G.bias,q.shadowNormalBias=G.normalBias,q.shadowRadius=G.radius,q.shadowMapSize=G.mapSize,i.spotShadow[v]=q,i.spotShadowMap[v]=Z,x++}v++}else if(I.isRectAreaLight){let U=t.get(I);U.color.copy(L).multiplyScalar(k),U.halfWidth.set(I.width*.5,0,0),U.halfHeight.set(0,I.height*.5,0),i.rectArea[S]=U,S++}else if(I.isPointLight){let U=t.get(I);if(U.color.copy(I.color).multiplyScalar(I.intensity),U.distance=I.distance,U.decay=I.decay,I.castShadow){let G=I.shadow,q=n.get(I);q.shadowIntensity=G.intensity,q.shadowBias=G.bias,q.shadowNormalBias=G.normalBias,q.shadowRadius=G.radius,q.shadowMapSize=G.mapSize,q.shadowCameraNear=G.camera.near,q.shadowCameraFar=G.camera.far,i.pointShadow[g]=q,i.pointShadowMap[g]=Z,i.pointShadowMatrix[g]=I.shadow.matrix,b++}i.point[g]=U,g++}else if(I.isHemisphereLight){let U=t.get(I);U.skyColor.copy(I.color).multiplyScalar(k),U.groundColor.copy(I.groundColor).multiplyScalar(k),i.hemi[_]=U,_++}}S>0&&(e.has("OES_texture_float_linear")===!0?(i.rectAreaLTC1=Tt.LTC_FLOAT_1,i.rectAreaLTC2=Tt.LTC_FLOAT_2):(i.rectAreaLTC1=Tt.LTC_HALF_1,i.rectAreaLTC2=Tt.LTC_HALF_2)),i.ambient[0]=u,i.ambient[1]=h,i.ambient[2]=f;let C=i.hash;(C.sunLength!==d||C.directionalLength!==m||C.pointLength!==g||C.spotLength!==v||C.rectAreaLength!==S||C.hemiLength!==_||C.numSunShadows!==p||C.numDirectionalShadows!==w||C.numPointShadows!==b||C.numSpotShadows!==x||C.numSpotMaps!==M||C.numLightProbes!==E)&&(i.sun.length=d,i.directional.length=m,i.spot.length=v,i.rectArea.length=S,i.point.length=g,i.hemi.length=_,i.sunShadow.length=p,i.sunShadowMap.length=p,i.sunShadowMatrix.length=y,i.sunShadowCascade.length=y,i.directionalShadow.length=w,i.directionalShadowMap.length=w,i.directionalShadowMatrix.length=w,i.pointShadow.length=b,i.pointShadowMap.length=b,i.pointShadowMatrix.length=b,i.spotShadow.length=x,i.spotShadowMap.length=x,i.spotLightMatrix.length=x+M-R,i.spotLightMap.length=M,i.numSpotLightShadowsWithMaps=R,i.numLightProbes=E,C.sunLength=d,C.directionalLength=m,C.pointLength=g,C.spotLength=v,C.rectAreaLength=S,C.hemiLength=_,C.numSunShadows=p,C.numDirectionalShadows=w,C.numPointShadows=b,C.numSpotShadows=x,C.numSpotMaps=M,C.numLightProbes=E,i.version=ZL++)}function c(l,u){let h=0,f=0,d=0,p=0,y=0,m=0,g=u.matrixWorldInverse;for(let v=0,S=l.length;v<S;v++){let _=l[v];if(_.isSunLight){let w=i.sun[h];w.direction.setFromMatrixPosition(_.matrixWorld),w.direction.transformDirection(g),h++}else if(_.isDirectionalLight){let w=i.directional[f];w.direction.setFromMatrixPosition(_.matrixWorld),r.setFromMatrixPosition(_.target.matrixWorld),w.direction.sub(r),w.direction.transformDirection(g),f++}else if(_.isSpotLight){let w=i.spot[p];w.position.setFromMatrixPosition(_.matrixWorld),w.position.applyMatrix4(g),w.direction.setFromMatrixPosition(_.matrixWorld),r.setFromMatrixPosition(_.target.matrixWorld),w.direction.sub(r),w.direction.transformDirection(g),p++}else if(_.isRectAreaLight){let w=i.rectArea[y];w.position.setFromMatrixPosition(_.matrixWorld),w.position.applyMatrix4(g),o.identity(),s.copy(_.matrixWorld),s.premultiply(g),o.extractRotation(s),w.halfWidth.set(_.width*.5,0,0),w.halfHeight.set(0,_.height*.5,0),w.halfWidth.applyMatrix4(o),w.halfHeight.applyMatrix4(o),y++}else if(_.isPointLight){let w=i.point[d];w.position.setFromMatrixPosition(_.matrixWorld),w.position.applyMatrix4(g),d++}else if(_.isHemisphereLight){let w=i.hemi[m];w.direction.setFromMatrixPosition(_.matrixWorld),w.direction.transformDirection(g),m++}}}return{setup:a,setupView:c,state:i}}function Pb(e){let t=new KL(e),n=[],i=[],r=[];function s(h){u.camera=h,n.length=0,i.length=0,r.length=0}function o(h){h.isLightProbeGrid?r.push(h):n.push(h)}function a(h){i.push(h)}function c(){t.setup(n),r.sort((h,f)=>h.priority-f.priority||h.id-f.id)}function l(h){t.setupView(n,h)}let u={lightsArray:n,shadowsArray:i,lightProbeGridArray:r,camera:null,lights:t,transmissionRenderTarget:{},textureUnits:0};return{init:s,state:u,setupLights:c,setupLightsView:l,pushLight:o,pushShadow:a}}function jL(e){let t=new WeakMap;function n(r,s=0){let o=t.get(r),a;return o===void 0?(a=new Pb(e),t.set(r,[a])):s>=o.length?(a=new Pb(e),o.push(a)):a=o[s],a}function i(){t=new WeakMap}return{get:n,dispose:i}}var QL=`void main() {
	gl_Position = vec4( position, 1.0 );
}`,tN=`uniform sampler2D shadow_pass;
uniform vec2 resolution;
uniform float radius;
void main() {
	const float samples = float( VSM_SAMPLES );
	float mean = 0.0;
	float squared_mean = 0.0;
	float uvStride = samples <= 1.0 ? 0.0 : 2.0 / ( samples - 1.0 );
	float uvStart = samples <= 1.0 ? 0.0 : - 1.0;
	for ( float i = 0.0; i < samples; i ++ ) {
		float uvOffset = uvStart + i * uvStride;
		#ifdef HORIZONTAL_PASS
			vec2 distribution = texture2D( shadow_pass, ( gl_FragCoord.xy + vec2( uvOffset, 0.0 ) * radius ) / resolution ).rg;
			mean += distribution.x;
			squared_mean += distribution.y * distribution.y + distribution.x * distribution.x;
		#else
			float depth = texture2D( shadow_pass, ( gl_FragCoord.xy + vec2( 0.0, uvOffset ) * radius ) / resolution ).r;
			mean += depth;
			squared_mean += depth * depth;
		#endif
	}
	mean = mean / samples;
	squared_mean = squared_mean / samples;
	float std_dev = sqrt( max( 0.0, squared_mean - mean * mean ) );
	gl_FragColor = vec4( mean, std_dev, 0.0, 1.0 );
}`,eN=[new W(1,0,0),new W(-1,0,0),new W(0,1,0),new W(0,-1,0),new W(0,0,1),new W(0,0,-1)],nN=[new W(0,-1,0),new W(0,-1,0),new W(0,0,1),new W(0,0,-1),new W(0,-1,0),new W(0,-1,0)],Lb=new we,qc=new W,Pm=new W;function iN(e,t,n){let i=new hs,r=new ie,s=new ie,o=new Te,a=new Ku,c=new ju,l={},u=n.maxTextureSize,h={[ys]:Tn,[Tn]:ys,[si]:si},f=new qi({defines:{VSM_SAMPLES:8},uniforms:{shadow_pass:{value:null},resolution:{value:new ie},radius:{value:4}},vertexShader:QL,fragmentShader:tN}),d=f.clone();d.defines.HORIZONTAL_PASS=1;let p=new ri;p.setAttribute("position",new bn(new Float32Array([-1,-1,.5,3,-1,.5,-1,3,.5]),3));let y=new Yn(p,f),m=this;this.enabled=!1,this.autoUpdate=!0,this.needsUpdate=!1,this.type=kc;let g=this.type;this.render=function(b,x,M){if(m.enabled===!1||m.autoUpdate===!1&&m.needsUpdate===!1||b.length===0)return;this.type===Tv&&(Ft("WebGLShadowMap: PCFSoftShadowMap has been removed. Using PCFShadowMap instead."),this.type=kc);let R=e.getRenderTarget(),E=e.getActiveCubeFace(),C=e.getActiveMipmapLevel(),N=e.state;N.setBlending(Zs),N.buffers.depth.getReversed()===!0?N.buffers.color.setClear(0,0,0,0):N.buffers.color.setClear(1,1,1,1),N.buffers.depth.setTest(!0),N.setScissorTest(!1);let B=g!==this.type;B&&x.traverse(function(I){I.material&&(Array.isArray(I.material)?I.material.forEach(L=>L.needsUpdate=!0):I.material.needsUpdate=!0)});for(let I=0,L=b.length;I<L;I++){let k=b[I],F=k.shadow;if(F===void 0){Ft("WebGLShadowMap:",k,"has no shadow.");continue}if(F.autoUpdate===!1&&F.needsUpdate===!1)continue;r.copy(F.mapSize);let Z=F.getFrameExtents();r.multiply(Z),s.copy(F.mapSize),(r.x>u||r.y>u)&&(r.x>u&&(s.x=Math.floor(u/Z.x),r.x=s.x*Z.x,F.mapSize.x=s.x),r.y>u&&(s.y=Math.floor(u/Z.y),r.y=s.y*Z.y,F.mapSize.y=s.y));let U=e.state.buffers.depth.getReversed();if(F.camera._reversedDepth=U,F.map===null||B===!0){if(F.map!==null&&(F.map.depthTexture!==null&&(F.map.depthTexture.dispose(),F.map.depthTexture=null),F.map.dispose()),this.type===na){if(k.isPointLight){Ft("WebGLShadowMap: VSM shadow maps are not supported for PointLights. Use PCF or BasicShadowMap instead.");continue}F.map=new qn(r.x,r.y,{format:xs,type:Ii,minFilter:Mn,magFilter:Mn,generateMipmaps:!1}),F.map.texture.name=k.name+".shadowMap",F.map.depthTexture=new Ir(r.x,r.y,Ri),F.map.depthTexture.name=k.name+".shadowMapDepth",F.map.depthTexture.format=Cr,F.map.depthTexture.compareFunction=null,F.map.depthTexture.minFilter=je,F.map.depthTexture.magFilter=je}else k.isPointLight?(F.map=new Zc(r.x),F.map.depthTexture=new Rc(r.x,Ci)):(F.map=new qn(r.x,r.y),F.map.depthTexture=new Ir(r.x,r.y,Ci)),F.map.depthTexture.name=k.name+".shadowMap",F.map.depthTexture.format=Cr,this.type===kc?(F.map.depthTexture.compareFunction=U?xm:ym,F.map.depthTexture.minFilter=Mn,F.map.depthTexture.magFilter=Mn):(F.map.depthTexture.compareFunction=null,F.map.depthTexture.minFilter=je,F.map.depthTexture.magFilter=je);F.camera.updateProjectionMatrix()}F.map.isWebGLCubeRenderTarget!==!0&&(F.map.width!==r.x||F.map.height!==r.y)&&F.map.setSize(r.x,r.y);let G=F.map.isWebGLCubeRenderTarget?6:F.getViewportCount();k.isPointLight!==!0&&F.updateMatrices(k,M);let q=(F.camera.layers.mask&4294967294)!==0?F.camera.layers:M.layers;for(let st=0;st<G;st++){let ct=F.getCamera(st);if(k.isPointLight){let $=F.camera,at=F.matrix,ft=k.distance||$.far;ft!==$.far&&($.far=ft,$.updateProjectionMatrix()),qc.setFromMatrixPosition(k.matrixWorld),$.position.copy(qc),Pm.copy($.position),Pm.add(eN[st]),$.up.copy(nN[st]),$.lookAt(Pm),$.updateMatrixWorld(),at.makeTranslation(-qc.x,-qc.y,-qc.z),Lb.multiplyMatrices($.projectionMatrix,$.matrixWorldInverse),F._frustum.setFromProjectionMatrix(Lb,$.coordinateSystem,$.reversedDepth)}if(F.map.isWebGLCubeRenderTarget)e.setRenderTarget(F.map,st),e.clear();else{st===0&&(e.setRenderTarget(F.map),e.clear());let $=F.getViewport(st);o.set(s.x*$.x,s.y*$.y,s.x*$.z,s.y*$.w),N.viewport(o)}i=F.getFrustum(st),_(x,M,ct,k,q,this.type)}F.isPointLightShadow!==!0&&this.type===na&&v(F,M),F.needsUpdate=!1}g=this.type,m.needsUpdate=!1,e.setRenderTarget(R,E,C)};function v(b,x){let M=t.update(y);f.defines.VSM_SAMPLES!==b.blurSamples&&(f.defines.VSM_SAMPLES=b.blurSamples,d.defines.VSM_SAMPLES=b.blurSamples,f.needsUpdate=!0,d.needsUpdate=!0),b.mapPass===null?b.mapPass=new qn(r.x,r.y,{format:xs,type:Ii}):(b.mapPass.width!==b.map.width||b.mapPass.height!==b.map.height)&&b.mapPass.setSize(b.map.width,b.map.height),f.uniforms.shadow_pass.value=b.map.depthTexture,f.uniforms.resolution.value.set(b.map.width,b.map.height),f.uniforms.radius.value=b.radius,e.setRenderTarget(b.mapPass),e.clear(),e.renderBufferDirect(x,null,M,f,y,null),d.uniforms.shadow_pass.value=b.mapPass.texture,d.uniforms.resolution.value.set(b.map.width,b.map.height),d.uniforms.radius.value=b.radius,e.setRenderTarget(b.map),e.clear(),e.renderBufferDirect(x,null,M,d,y,null)}function S(b,x,M,R){let E=null,C=M.isPointLight===!0?b.customDistanceMaterial:b.customDepthMaterial;if(C!==void 0)E=C;else if(E=M.isPointLight===!0?c:a,e.localClippingEnabled&&x.clipShadows===!0&&Array.isArray(x.clippingPlanes)&&x.clippingPlanes.length!==0||x.displacementMap&&x.displacementScale!==0||x.alphaMap&&x.alphaTest>0||x.map&&x.alphaTest>0||x.alphaToCoverage===!0){let N=E.uuid,B=x.uuid,I=l[N];I===void 0&&(I={},l[N]=I);let L=I[B];L===void 0&&(L=E.clone(),I[B]=L,x.addEventListener("dispose",w)),E=L}if(E.visible=x.visible,E.wireframe=x.wireframe,R===na?E.side=x.shadowSide!==null?x.shadowSide:x.side:E.side=x.shadowSide!==null?x.shadowSide:h[x.side],E.alphaMap=x.alphaMap,E.alphaTest=x.alphaToCoverage===!0?.5:x.alphaTest,E.map=x.map,E.clipShadows=x.clipShadows,E.clippingPlanes=x.clippingPlanes,E.clipIntersection=x.clipIntersection,E.displacementMap=x.displacementMap,E.displacementScale=x.displacementScale,E.displacementBias=x.displacementBias,E.wireframeLinewidth=x.wireframeLinewidth,E.linewidth=x.linewidth,M.isPointLight===!0&&E.isMeshDistanceMaterial===!0){let N=e.properties.get(E);N.light=M}return E}function _(b,x,M,R,E,C){if(b.visible===!1)return;if(b.layers.test(E)&&(b.isMesh||b.isLine||b.isPoints)&&(b.castShadow||b.receiveShadow&&C===na)&&(!b.frustumCulled||b.intersectsFrustum(i))){b.modelViewMatrix.multiplyMatrices(M.matrixWorldInverse,b.matrixWorld);let I=t.update(b),L=b.material;if(Array.isArray(L)){let k=I.groups;for(let F=0,Z=k.length;F<Z;F++){let U=k[F],G=L[U.materialIndex];if(G&&G.visible){let q=S(b,G,R,C);b.onBeforeShadow(e,b,x,M,I,q,U),e.renderBufferDirect(M,null,I,q,b,U),b.onAfterShadow(e,b,x,M,I,q,U)}}}else if(L.visible){let k=S(b,L,R,C);b.onBeforeShadow(e,b,x,M,I,k,null),e.renderBufferDirect(M,null,I,k,b,null),b.onAfterShadow(e,b,x,M,I,k,null)}}let B=b.children;for(let I=0,L=B.length;I<L;I++)_(B[I],x,M,R,E,C)}function w(b){b.target.removeEventListener("dispose",w);for(let M in l){let R=l[M],E=b.target.uuid;E in R&&(R[E].dispose(),delete R[E])}}}function rN(e,t){function n(){let D=!1,et=new Te,j=null,vt=new Te(0,0,0,0);return{setMask:function(dt){j!==dt&&!D&&(e.colorMask(dt,dt,dt,dt),j=dt)},setLocked:function(dt){D=dt},setClear:function(dt,xt,Nt,Yt,ht){ht===!0&&(dt*=Yt,xt*=Yt,Nt*=Yt),et.set(dt,xt,Nt,Yt),vt.equals(et)===!1&&(e.clearColor(dt,xt,Nt,Yt),vt.copy(et))},reset:function(){D=!1,j=null,vt.set(-1,0,0,0)}}}function i(){let D=!1,et=!1,j=null,vt=null,dt=null;return{setReversed:function(xt){if(et!==xt){let Nt=t.get("EXT_clip_control");xt?Nt.clipControlEXT(Nt.LOWER_LEFT_EXT,Nt.ZERO_TO_ONE_EXT):Nt.clipControlEXT(Nt.LOWER_LEFT_EXT,Nt.NEGATIVE_ONE_TO_ONE_EXT),et=xt;let Yt=dt;dt=null,this.setClear(Yt)}},getReversed:function(){return et},setTest:function(xt){xt?rt(e.DEPTH_TEST):J(e.DEPTH_TEST)},setMask:function(xt){j!==xt&&!D&&(e.depthMask(xt),j=xt)},setFunc:function(xt){if(et&&(xt=sb[xt]),vt!==xt){switch(xt){case Nu:e.depthFunc(e.NEVER);break;case Du:e.depthFunc(e.ALWAYS);break;case Fu:e.depthFunc(e.LESS);break;case qo:e.depthFunc(e.LEQUAL);break;case Uu:e.depthFunc(e.EQUAL);break;case Ou:e.depthFunc(e.GEQUAL);break;case Bu:e.depthFunc(e.GREATER);break;case ku:e.depthFunc(e.NOTEQUAL);break;default:e.depthFunc(e.LEQUAL)}vt=xt}},setLocked:function(xt){D=xt},setClear:function(xt){dt!==xt&&(dt=xt,et&&(xt=1-xt),e.clearDepth(xt))},reset:function(){D=!1,j=null,vt=null,dt=null,et=!1}}}function r(){let D=!1,et=null,j=null,vt=null,dt=null,xt=null,Nt=null,Yt=null,ht=null;return{setTest:function(Dt){D||(Dt?rt(e.STENCIL_TEST):J(e.STENCIL_TEST))},setMask:function(Dt){et!==Dt&&!D&&(e.stencilMask(Dt),et=Dt)},setFunc:function(Dt,qt,wt){(j!==Dt||vt!==qt||dt!==wt)&&(e.stencilFunc(Dt,qt,wt),j=Dt,vt=qt,dt=wt)},setOp:function(Dt,qt,wt){(xt!==Dt||Nt!==qt||Yt!==wt)&&(e.stencilOp(Dt,qt,wt),xt=Dt,Nt=qt,Yt=wt)},setLocked:function(Dt){D=Dt},setClear:function(Dt){ht!==Dt&&(e.clearStencil(Dt),ht=Dt)},reset:function(){D=!1,et=null,j=null,vt=null,dt=null,xt=null,Nt=null,Yt=null,ht=null}}}let s=new n,o=new i,a=new r,c={},l=new WeakMap,u={},h={},f={},d=new WeakMap,p=[],y=null,m=!1,g=null,v=null,S=null,_=null,w=null,b=null,x=null,M=new Zt(0,0,0),R=0,E=!1,C=null,N=null,B=null,I=null,L=null,k=e.getParameter(e.MAX_COMBINED_TEXTURE_IMAGE_UNITS),F=!1,Z=0,U=e.getParameter(e.VERSION);U.indexOf("WebGL")!==-1?(Z=parseFloat(/^WebGL (\d)/.exec(U)[1]),F=Z>=1):U.indexOf("OpenGL ES")!==-1&&(Z=parseFloat(/^OpenGL ES (\d)/.exec(U)[1]),F=Z>=2);let G=null,q={},st=e.getParameter(e.SCISSOR_BOX),ct=e.getParameter(e.VIEWPORT),$=new Te().fromArray(st),at=new Te().fromArray(ct);function ft(D,et,j,vt){let dt=new Uint8Array(4),xt=e.createTexture();e.bindTexture(D,xt),e.texParameteri(D,e.TEXTURE_MIN_FILTER,e.NEAREST),e.texParameteri(D,e.TEXTURE_MAG_FILTER,e.NEAREST);for(let Nt=0;Nt<j;Nt++)D===e.TEXTURE_3D||D===e.TEXTURE_2D_ARRAY?e.texImage3D(et,0,e.RGBA,1,1,vt,0,e.RGBA,e.UNSIGNED_BYTE,dt):e.texImage2D(et+Nt,0,e.RGBA,1,1,0,e.RGBA,e.UNSIGNED_BYTE,dt);return xt}let ot={};ot[e.TEXTURE_2D]=ft(e.TEXTURE_2D,e.TEXTURE_2D,1),ot[e.TEXTURE_CUBE_MAP]=ft(e.TEXTURE_CUBE_MAP,e.TEXTURE_CUBE_MAP_POSITIVE_X,6),ot[e.TEXTURE_2D_ARRAY]=ft(e.TEXTURE_2D_ARRAY,e.TEXTURE_2D_ARRAY,1,1),ot[e.TEXTURE_3D]=ft(e.TEXTURE_3D,e.TEXTURE_3D,1,1),s.setClear(0,0,0,1),o.setClear(1),a.setClear(0),rt(e.DEPTH_TEST),o.setFunc(qo),ce(!1),oe(Jp),rt(e.CULL_FACE),Ut(Zs);function rt(D){u[D]!==!0&&(e.enable(D),u[D]=!0)}function J(D){u[D]!==!1&&(e.disable(D),u[D]=!1)}function gt(D,et){return f[D]!==et?(e.bindFramebuffer(D,et),f[D]=et,D===e.DRAW_FRAMEBUFFER&&(f[e.FRAMEBUFFER]=et),D===e.FRAMEBUFFER&&(f[e.DRAW_FRAMEBUFFER]=et),!0):!1}function lt(D,et){let j=p,vt=!1;if(D){j=d.get(et),j===void 0&&(j=[],d.set(et,j));let dt=D.textures;if(j.length!==dt.length||j[0]!==e.COLOR_ATTACHMENT0){for(let xt=0,Nt=dt.length;xt<Nt;xt++)j[xt]=e.COLOR_ATTACHMENT0+xt;j.length=dt.length,vt=!0}}else j[0]!==e.BACK&&(j[0]=e.BACK,vt=!0);vt&&e.drawBuffers(j)}function K(D){return y!==D?(e.useProgram(D),y=D,!0):!1}let It={[Js]:e.FUNC_ADD,[Ev]:e.FUNC_SUBTRACT,[Cv]:e.FUNC_REVERSE_SUBTRACT};It[Rv]=e.MIN,It[Iv]=e.MAX;let pt={[Pv]:e.ZERO,[Lv]:e.ONE,[Nv]:e.SRC_COLOR,[tm]:e.SRC_ALPHA,[kv]:e.SRC_ALPHA_SATURATE,[Ov]:e.DST_COLOR,[Fv]:e.DST_ALPHA,[Dv]:e.ONE_MINUS_SRC_COLOR,[em]:e.ONE_MINUS_SRC_ALPHA,[Bv]:e.ONE_MINUS_DST_COLOR,[Uv]:e.ONE_MINUS_DST_ALPHA,[zv]:e.CONSTANT_COLOR,[Gv]:e.ONE_MINUS_CONSTANT_COLOR,[Vv]:e.CONSTANT_ALPHA,[Hv]:e.ONE_MINUS_CONSTANT_ALPHA};function Ut(D,et,j,vt,dt,xt,Nt,Yt,ht,Dt){if(D===Zs){m===!0&&(J(e.BLEND),m=!1);return}if(m===!1&&(rt(e.BLEND),m=!0),D!==Av){if(D!==g||Dt!==E){if((v!==Js||w!==Js)&&(e.blendEquation(e.FUNC_ADD),v=Js,w=Js),Dt)switch(D){case ia:e.blendFuncSeparate(e.ONE,e.ONE_MINUS_SRC_ALPHA,e.ONE,e.ONE_MINUS_SRC_ALPHA);break;case Kp:e.blendFunc(e.ONE,e.ONE);break;case jp:e.blendFuncSeparate(e.ZERO,e.ONE_MINUS_SRC_COLOR,e.ZERO,e.ONE);break;case Qp:e.blendFuncSeparate(e.DST_COLOR,e.ONE_MINUS_SRC_ALPHA,e.ZERO,e.ONE);break;default:kt("WebGLState: Invalid blending: ",D);break}else switch(D){case ia:e.blendFuncSeparate(e.SRC_ALPHA,e.ONE_MINUS_SRC_ALPHA,e.ONE,e.ONE_MINUS_SRC_ALPHA);break;case Kp:e.blendFuncSeparate(e.SRC_ALPHA,e.ONE,e.ONE,e.ONE);break;case jp:kt("WebGLState: SubtractiveBlending requires material.premultipliedAlpha = true");break;case Qp:kt("WebGLState: MultiplyBlending requires material.premultipliedAlpha = true");break;default:kt("WebGLState: Invalid blending: ",D);break}S=null,_=null,b=null,x=null,M.set(0,0,0),R=0,g=D,E=Dt}return}dt=dt||et,xt=xt||j,Nt=Nt||vt,(et!==v||dt!==w)&&(e.blendEquationSeparate(It[et],It[dt]),v=et,w=dt),(j!==S||vt!==_||xt!==b||Nt!==x)&&(e.blendFuncSeparate(pt[j],pt[vt],pt[xt],pt[Nt]),S=j,_=vt,b=xt,x=Nt),(Yt.equals(M)===!1||ht!==R)&&(e.blendColor(Yt.r,Yt.g,Yt.b,ht),M.copy(Yt),R=ht),g=D,E=!1}function Gt(D,et){D.side===si?J(e.CULL_FACE):rt(e.CULL_FACE);let j=D.side===Tn;et&&(j=!j),ce(j),D.blending===ia&&D.transparent===!1?Ut(Zs):Ut(D.blending,D.blendEquation,D.blendSrc,D.blendDst,D.blendEquationAlpha,D.blendSrcAlpha,D.blendDstAlpha,D.blendColor,D.blendAlpha,D.premultipliedAlpha),o.setFunc(D.depthFunc),o.setTest(D.depthTest),o.setMask(D.depthWrite),s.setMask(D.colorWrite);let vt=D.stencilWrite;a.setTest(vt),vt&&(a.setMask(D.stencilWriteMask),a.setFunc(D.stencilFunc,D.stencilRef,D.stencilFuncMask),a.setOp(D.stencilFail,D.stencilZFail,D.stencilZPass)),Be(D.polygonOffset,D.polygonOffsetFactor,D.polygonOffsetUnits),D.alphaToCoverage===!0?rt(e.SAMPLE_ALPHA_TO_COVERAGE):J(e.SAMPLE_ALPHA_TO_COVERAGE)}function ce(D){C!==D&&(D?e.frontFace(e.CW):e.frontFace(e.CCW),C=D)}function oe(D){D!==Sv?(rt(e.CULL_FACE),D!==N&&(D===Jp?e.cullFace(e.BACK):D===wv?e.cullFace(e.FRONT):e.cullFace(e.FRONT_AND_BACK))):J(e.CULL_FACE),N=D}function Xe(D){D!==B&&(F&&e.lineWidth(D),B=D)}function Be(D,et,j){D?(rt(e.POLYGON_OFFSET_FILL),(I!==et||L!==j)&&(I=et,L=j,o.getReversed()&&(et=-et,j=-j),e.polygonOffset(et,j))):J(e.POLYGON_OFFSET_FILL)}function Ln(D){D?rt(e.SCISSOR_TEST):J(e.SCISSOR_TEST)}function xn(D){D===void 0&&(D=e.TEXTURE0+k-1),G!==D&&(e.activeTexture(D),G=D)}function Nn(D,et,j){j===void 0&&(G===null?j=e.TEXTURE0+k-1:j=G);let vt=q[j];vt===void 0&&(vt={type:void 0,texture:void 0},q[j]=vt),(vt.type!==D||vt.texture!==et)&&(G!==j&&(e.activeTexture(j),G=j),e.bindTexture(D,et||ot[D]),vt.type=D,vt.texture=et)}function z(){let D=q[G];D!==void 0&&D.type!==void 0&&(e.bindTexture(D.type,null),D.type=void 0,D.texture=void 0)}function Dn(){try{e.compressedTexImage2D(...arguments)}catch(D){kt("WebGLState:",D)}}function _e(){try{e.compressedTexImage3D(...arguments)}catch(D){kt("WebGLState:",D)}}function ve(){try{e.texSubImage2D(...arguments)}catch(D){kt("WebGLState:",D)}}function mt(){try{e.texSubImage3D(...arguments)}catch(D){kt("WebGLState:",D)}}function Ce(){try{e.compressedTexSubImage2D(...arguments)}catch(D){kt("WebGLState:",D)}}function Lt(){try{e.compressedTexSubImage3D(...arguments)}catch(D){kt("WebGLState:",D)}}function Bt(){try{e.texStorage2D(...arguments)}catch(D){kt("WebGLState:",D)}}function P(){try{e.texStorage3D(...arguments)}catch(D){kt("WebGLState:",D)}}function T(){try{e.texImage2D(...arguments)}catch(D){kt("WebGLState:",D)}}function V(){try{e.texImage3D(...arguments)}catch(D){kt("WebGLState:",D)}}function ut(D){return h[D]!==void 0?h[D]:e.getParameter(D)}function nt(D,et){h[D]!==et&&(e.pixelStorei(D,et),h[D]=et)}function yt(D){$.equals(D)===!1&&(e.scissor(D.x,D.y,D.z,D.w),$.copy(D))}function Mt(D){at.equals(D)===!1&&(e.viewport(D.x,D.y,D.z,D.w),at.copy(D))}function Q(D,et){let j=l.get(et);j===void 0&&(j=new WeakMap,l.set(et,j));let vt=j.get(D);vt===void 0&&(vt=e.getUniformBlockIndex(et,D.name),e.uniformBlockBinding(et,vt,vt),j.set(D,vt))}function tt(D,et,j){let dt=l.get(et).get(D);c[dt]!==j&&(e.bindBufferBase(e.UNIFORM_BUFFER,dt,j),c[dt]=j)}function _t(){e.disable(e.BLEND),e.disable(e.CULL_FACE),e.disable(e.DEPTH_TEST),e.disable(e.POLYGON_OFFSET_FILL),e.disable(e.SCISSOR_TEST),e.disable(e.STENCIL_TEST),e.disable(e.SAMPLE_ALPHA_TO_COVERAGE),e.blendEquation(e.FUNC_ADD),e.blendFunc(e.ONE,e.ZERO),e.blendFuncSeparate(e.ONE,e.ZERO,e.ONE,e.ZERO),e.blendColor(0,0,0,0),e.colorMask(!0,!0,!0,!0),e.clearColor(0,0,0,0),e.depthMask(!0),e.depthFunc(e.LESS),o.setReversed(!1),e.clearDepth(1),e.stencilMask(4294967295),e.stencilFunc(e.ALWAYS,0,4294967295),e.stencilOp(e.KEEP,e.KEEP,e.KEEP),e.clearStencil(0),e.cullFace(e.BACK),e.frontFace(e.CCW),e.polygonOffset(0,0),e.activeTexture(e.TEXTURE0),e.bindFramebuffer(e.FRAMEBUFFER,null),e.bindFramebuffer(e.DRAW_FRAMEBUFFER,null),e.bindFramebuffer(e.READ_FRAMEBUFFER,null),e.useProgram(null),e.lineWidth(1),e.scissor(0,0,e.canvas.width,e.canvas.height),e.viewport(0,0,e.canvas.width,e.canvas.height),e.pixelStorei(e.PACK_ALIGNMENT,4),e.pixelStorei(e.UNPACK_ALIGNMENT,4),e.pixelStorei(e.UNPACK_FLIP_Y_WEBGL,!1),e.pixelStorei(e.UNPACK_PREMULTIPLY_ALPHA_WEBGL,!1),e.pixelStorei(e.UNPACK_COLORSPACE_CONVERSION_WEBGL,e.BROWSER_DEFAULT_WEBGL),e.pixelStorei(e.PACK_ROW_LENGTH,0),e.pixelStorei(e.PACK_SKIP_PIXELS,0),e.pixelStorei(e.PACK_SKIP_ROWS,0),e.pixelStorei(e.UNPACK_ROW_LENGTH,0),e.pixelStorei(e.UNPACK_IMAGE_HEIGHT,0),e.pixelStorei(e.UNPACK_SKIP_PIXELS,0),e.pixelStorei(e.UNPACK_SKIP_ROWS,0),e.pixelStorei(e.UNPACK_SKIP_IMAGES,0),u={},h={},G=null,q={},f={},c={},d=new WeakMap,p=[],y=null,m=!1,g=null,v=null,S=null,_=null,w=null,b=null,x=null,M=new Zt(0,0,0),R=0,E=!1,C=null,N=null,B=null,I=null,L=null,$.set(0,0,e.canvas.width,e.canvas.height),at.set(0,0,e.canvas.width,e.canvas.height),s.reset(),o.reset(),a.reset()}return{buffers:{color:s,depth:o,stencil:a},enable:rt,disable:J,bindFramebuffer:gt,drawBuffers:lt,useProgram:K,setBlending:Ut,setMaterial:Gt,setFlipSided:ce,setCullFace:oe,setLineWidth:Xe,setPolygonOffset:Be,setScissorTest:Ln,activeTexture:xn,bindTexture:Nn,unbindTexture:z,compressedTexImage2D:Dn,compressedTexImage3D:_e,texImage2D:T,texImage3D:V,pixelStorei:nt,getParameter:ut,updateUBOMapping:Q,uniformBlockBinding:tt,texStorage2D:Bt,texStorage3D:P,texSubImage2D:ve,texSubImage3D:mt,compressedTexSubImage2D:Ce,compressedTexSubImage3D:Lt,scissor:yt,viewport:Mt,reset:_t}}function sN(e,t,n,i,r,s,o){let a=t.has("WEBGL_multisampled_render_to_texture")?t.get("WEBGL_multisampled_render_to_texture"):null,c=typeof navigator>"u"?!1:/OculusBrowser/g.test(navigator.userAgent),l=new ie,u=new WeakMap,h=new Set,f,d=new WeakMap,p=new Set,y=new FinalizationRegistry(P=>p.delete(P)),m=!1;try{m=typeof OffscreenCanvas<"u"&&new OffscreenCanvas(1,1).getContext("2d")!==null}catch{}function g(P,T){return m?new OffscreenCanvas(P,T):Mc("canvas")}function v(P,T,V){let ut=1,nt=Bt(P);if((nt.width>V||nt.height>V)&&(ut=V/Math.max(nt.width,nt.height)),ut<1)if(typeof HTMLImageElement<"u"&&P instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&P instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&P instanceof ImageBitmap||typeof VideoFrame<"u"&&P instanceof VideoFrame){let yt=Math.floor(ut*nt.width),Mt=Math.floor(ut*nt.height);f===void 0&&(f=g(yt,Mt));let Q=T?g(yt,Mt):f;return Q.width=yt,Q.height=Mt,Q.getContext("2d").drawImage(P,0,0,yt,Mt),Ft("WebGLRenderer: Texture has been resized from ("+nt.width+"x"+nt.height+") to ("+yt+"x"+Mt+")."),Q}else return"data"in P&&Ft("WebGLRenderer: Image in DataTexture is too big ("+nt.width+"x"+nt.height+")."),P;return P}function S(P){return P.generateMipmaps}function _(P){e.generateMipmap(P)}function w(P){return P.isWebGLCubeRenderTarget?e.TEXTURE_CUBE_MAP:P.isWebGL3DRenderTarget?e.TEXTURE_3D:P.isWebGLArrayRenderTarget||P.isCompressedArrayTexture?e.TEXTURE_2D_ARRAY:e.TEXTURE_2D}function b(P,T,V,ut,nt,yt=!1){if(P!==null){if(e[P]!==void 0)return e[P];Ft("WebGLRenderer: Attempt to use non-existing WebGL internal format '"+P+"'")}let Mt;ut&&(Mt=t.get("EXT_texture_norm16"),Mt||Ft("WebGLRenderer: Unable to use normalized textures without EXT_texture_norm16 extension"));let Q=T;if(T===e.RED&&(V===e.FLOAT&&(Q=e.R32F),V===e.HALF_FLOAT&&(Q=e.R16F),V===e.UNSIGNED_BYTE&&(Q=e.R8),V===e.UNSIGNED_SHORT&&Mt&&(Q=Mt.R16_EXT),V===e.SHORT&&Mt&&(Q=Mt.R16_SNORM_EXT)),T===e.RED_INTEGER&&(V===e.UNSIGNED_BYTE&&(Q=e.R8UI),V===e.UNSIGNED_SHORT&&(Q=e.R16UI),V===e.UNSIGNED_INT&&(Q=e.R32UI),V===e.BYTE&&(Q=e.R8I),V===e.SHORT&&(Q=e.R16I),V===e.INT&&(Q=e.R32I)),T===e.RG&&(V===e.FLOAT&&(Q=e.RG32F),V===e.HALF_FLOAT&&(Q=e.RG16F),V===e.UNSIGNED_BYTE&&(Q=e.RG8),V===e.UNSIGNED_SHORT&&Mt&&(Q=Mt.RG16_EXT),V===e.SHORT&&Mt&&(Q=Mt.RG16_SNORM_EXT)),T===e.RG_INTEGER&&(V===e.UNSIGNED_BYTE&&(Q=e.RG8UI),V===e.UNSIGNED_SHORT&&(Q=e.RG16UI),V===e.UNSIGNED_INT&&(Q=e.RG32UI),V===e.BYTE&&(Q=e.RG8I),V===e.SHORT&&(Q=e.RG16I),V===e.INT&&(Q=e.RG32I)),T===e.RGB_INTEGER&&(V===e.UNSIGNED_BYTE&&(Q=e.RGB8UI),V===e.UNSIGNED_SHORT&&(Q=e.RGB16UI),V===e.UNSIGNED_INT&&(Q=e.RGB32UI),V===e.BYTE&&(Q=e.RGB8I),V===e.SHORT&&(Q=e.RGB16I),V===e.INT&&(Q=e.RGB32I)),T===e.RGBA_INTEGER&&(V===e.UNSIGNED_BYTE&&(Q=e.RGBA8UI),V===e.UNSIGNED_SHORT&&(Q=e.RGBA16UI),V===e.UNSIGNED_INT&&(Q=e.RGBA32UI),V===e.BYTE&&(Q=e.RGBA8I),V===e.SHORT&&(Q=e.RGBA16I),V===e.INT&&(Q=e.RGBA32I)),T===e.RGB&&(V===e.UNSIGNED_SHORT&&Mt&&(Q=Mt.RGB16_EXT),V===e.SHORT&&Mt&&(Q=Mt.RGB16_SNORM_EXT),V===e.UNSIGNED_INT_5_9_9_9_REV&&(Q=e.RGB9_E5),V===e.UNSIGNED_INT_10F_11F_11F_REV&&(Q=e.R11F_G11F_B10F)),T===e.RGBA){let tt=yt?bc:ee.getTransfer(nt);V===e.FLOAT&&(Q=e.RGBA32F),V===e.HALF_FLOAT&&(Q=e.RGBA16F),V===e.UNSIGNED_BYTE&&(Q=tt===ue?e.SRGB8_ALPHA8:e.RGBA8),V===e.UNSIGNED_SHORT&&Mt&&(Q=Mt.RGBA16_EXT),V===e.SHORT&&Mt&&(Q=Mt.RGBA16_SNORM_EXT),V===e.UNSIGNED_SHORT_4_4_4_4&&(Q=e.RGBA4),V===e.UNSIGNED_SHORT_5_5_5_1&&(Q=e.RGB5_A1)}return(Q===e.R16F||Q===e.R32F||Q===e.RG16F||Q===e.RG32F||Q===e.RGBA16F||Q===e.RGBA32F)&&t.get("EXT_color_buffer_float"),Q}function x(P,T){let V;return P?T===null||T===Ci||T===js?V=e.DEPTH24_STENCIL8:T===Ri?V=e.DEPTH32F_STENCIL8:T===sa&&(V=e.DEPTH24_STENCIL8,Ft("DepthTexture: 16 bit depth attachment is not supported with stencil. Using 24-bit attachment.")):T===null||T===Ci||T===js?V=e.DEPTH_COMPONENT24:T===Ri?V=e.DEPTH_COMPONENT32F:T===sa&&(V=e.DEPTH_COMPONENT16),V}function M(P,T){return S(P)===!0||P.isFramebufferTexture&&P.minFilter!==je&&P.minFilter!==Mn?Math.log2(Math.max(T.width,T.height))+1:P.mipmaps.length>0?P.mipmaps.length:P.isCompressedTexture&&Array.isArray(P.image)?T.mipmaps.length:1}function R(P){let T=new WeakRef(P);i.get(P).__ref=T,p.add(T),y.register(P,T,T)}function E(P){let T=i.get(P).__ref;T!==void 0&&(p.delete(T),y.unregister(T))}function C(P){B(P.target)}function N(P){I(P.target)}function B(P){P.removeEventListener("dispose",C),E(P),k(P),P.isVideoTexture&&u.delete(P),P.isHTMLTexture&&h.delete(P)}function I(P){P.removeEventListener("dispose",N),E(P),Z(P)}function L(){for(let P of p){let T=P.deref();T!==void 0&&(T.isRenderTarget===!0?I(T):B(T))}p.clear(),h.clear()}function k(P){let T=i.get(P);if(T.__webglInit===void 0)return;let V=P.source,ut=d.get(V);if(ut){let nt=ut[T.__cacheKey];nt.usedTimes--,nt.usedTimes===0&&F(P),Object.keys(ut).length===0&&d.delete(V)}i.remove(P)}function F(P){let T=i.get(P);e.deleteTexture(T.__webglTexture);let V=P.source,ut=d.get(V);delete ut[T.__cacheKey],o.memory.textures--}function Z(P){let T=i.get(P);T.__depthDisposeCallback&&T.__depthDisposeCallback();let V=P.depthTexture;if(V&&V.renderTarget===P&&B(V),P.isWebGLCubeRenderTarget)for(let nt=0;nt<6;nt++){if(Array.isArray(T.__webglFramebuffer[nt]))for(let yt=0;yt<T.__webglFramebuffer[nt].length;yt++)e.deleteFramebuffer(T.__webglFramebuffer[nt][yt]);else e.deleteFramebuffer(T.__webglFramebuffer[nt]);T.__webglDepthbuffer&&e.deleteRenderbuffer(T.__webglDepthbuffer[nt])}else{if(Array.isArray(T.__webglFramebuffer))for(let nt=0;nt<T.__webglFramebuffer.length;nt++)e.deleteFramebuffer(T.__webglFramebuffer[nt]);else e.deleteFramebuffer(T.__webglFramebuffer);if(T.__webglDepthbuffer&&e.deleteRenderbuffer(T.__webglDepthbuffer),T.__webglMultisampledFramebuffer&&e.deleteFramebuffer(T.__webglMultisampledFramebuffer),T.__webglColorRenderbuffer)for(let nt=0;nt<T.__webglColorRenderbuffer.length;nt++)T.__webglColorRenderbuffer[nt]&&e.deleteRenderbuffer(T.__webglColorRenderbuffer[nt]);T.__webglDepthRenderbuffer&&e.deleteRenderbuffer(T.__webglDepthRenderbuffer)}let ut=P.textures;for(let nt=0,yt=ut.length;nt<yt;nt++){let Mt=i.get(ut[nt]);Mt.__webglTexture&&(e.deleteTexture(Mt.__webglTexture),o.memory.textures--),i.remove(ut[nt])}i.remove(P)}let U=0;function G(){U=0}function q(){return U}function st(P){U=P}function ct(){let P=U;return P>=r.maxTextures&&Ft("WebGLTextures: Trying to use "+(P+1)+" texture units while this GPU supports only "+r.maxTextures),U+=1,P}function $(P){let T=[];return T.push(P.wrapS),T.push(P.wrapT),T.push(P.wrapR||0),T.push(P.magFilter),T.push(P.minFilter),T.push(P.anisotropy),T.push(P.internalFormat),T.push(P.format),T.push(P.type),T.push(P.generateMipmaps),T.push(P.mipmapsAutoUpdate),T.push(P.premultiplyAlpha),T.push(P.flipY),T.push(P.unpackAlignment),T.push(P.colorSpace),T.join()}function at(P,T){let V=i.get(P);if(P.isVideoTexture&&Ce(P),P.isRenderTargetTexture===!1&&P.isExternalTexture!==!0&&P.version>0&&V.__version!==P.version){let ut=P.image;if(ut===null)Ft("WebGLRenderer: Texture marked for update but no image data found.");else if(ut.complete===!1)Ft("WebGLRenderer: Texture marked for update but image is incomplete");else{Gt(V,P,T);return}}else P.isExternalTexture&&(V.__webglTexture=P.sourceTexture?P.sourceTexture:null);n.bindTexture(e.TEXTURE_2D,V.__webglTexture,e.TEXTURE0+T)}function ft(P,T){let V=i.get(P);if(P.isRenderTargetTexture===!1&&P.version>0&&V.__version!==P.version){Gt(V,P,T);return}else P.isExternalTexture&&(V.__webglTexture=P.sourceTexture?P.sourceTexture:null);n.bindTexture(e.TEXTURE_2D_ARRAY,V.__webglTexture,e.TEXTURE0+T)}function ot(P,T){let V=i.get(P);if(P.isRenderTargetTexture===!1&&P.version>0&&V.__version!==P.version){Gt(V,P,T);return}n.bindTexture(e.TEXTURE_3D,V.__webglTexture,e.TEXTURE0+T)}function rt(P,T){let V=i.get(P);if(P.version>0&&V.__version!==P.version){ce(V,P,T);return}n.bindTexture(e.TEXTURE_CUBE_MAP,V.__webglTexture,e.TEXTURE0+T)}let J={[zu]:e.REPEAT,[$i]:e.CLAMP_TO_EDGE,[Gu]:e.MIRRORED_REPEAT},gt={[je]:e.NEAREST,[Xv]:e.NEAREST_MIPMAP_NEAREST,[zc]:e.NEAREST_MIPMAP_LINEAR,[Mn]:e.LINEAR,[mf]:e.LINEAR_MIPMAP_NEAREST,[Pr]:e.LINEAR_MIPMAP_LINEAR},lt={[Jv]:e.NEVER,[_m]:e.ALWAYS,[Kv]:e.LESS,[ym]:e.LEQUAL,[jv]:e.EQUAL,[xm]:e.GEQUAL,[Qv]:e.GREATER,[tb]:e.NOTEQUAL};function K(P,T){if(T.type===Ri&&t.has("OES_texture_float_linear")===!1&&(T.magFilter===Mn||T.magFilter===mf||T.magFilter===zc||T.magFilter===Pr||T.minFilter===Mn||T.minFilter===mf||T.minFilter===zc||T.minFilter===Pr)&&Ft("WebGLRenderer: Unable to use linear filtering with floating point textures. OES_texture_float_linear not supported on this device."),e.texParameteri(P,e.TEXTURE_WRAP_S,J[T.wrapS]),e.texParameteri(P,e.TEXTURE_WRAP_T,J[T.wrapT]),(P===e.TEXTURE_3D||P===e.TEXTURE_2D_ARRAY)&&e.texParameteri(P,e.TEXTURE_WRAP_R,J[T.wrapR]),e.texParameteri(P,e.TEXTURE_MAG_FILTER,gt[T.magFilter]),e.texParameteri(P,e.TEXTURE_MIN_FILTER,gt[T.minFilter]),T.compareFunction&&(e.texParameteri(P,e.TEXTURE_COMPARE_MODE,e.COMPARE_REF_TO_TEXTURE),e.texParameteri(P,e.TEXTURE_COMPARE_FUNC,lt[T.compareFunction])),t.has("EXT_texture_filter_anisotropic")===!0){if(T.magFilter===je||T.minFilter!==zc&&T.minFilter!==Pr||T.type===Ri&&t.has("OES_texture_float_linear")===!1)return;if(T.anisotropy>1||i.get(T).__currentAnisotropy){let V=t.get("EXT_texture_filter_anisotropic");e.texParameterf(P,V.TEXTURE_MAX_ANISOTROPY_EXT,Math.min(T.anisotropy,r.getMaxAnisotropy())),i.get(T).__currentAnisotropy=T.anisotropy}}}function It(P,T){let V=!1;P.__webglInit===void 0&&(P.__webglInit=!0,T.addEventListener("dispose",C),R(T));let ut=T.source,nt=d.get(ut);nt===void 0&&(nt={},d.set(ut,nt));let yt=$(T);if(yt!==P.__cacheKey){nt[yt]===void 0&&(nt[yt]={texture:e.createTexture(),usedTimes:0},o.memory.textures++,V=!0),nt[yt].usedTimes++;let Mt=nt[P.__cacheKey];Mt!==void 0&&(nt[P.__cacheKey].usedTimes--,Mt.usedTimes===0&&F(T)),P.__cacheKey=yt,P.__webglTexture=nt[yt].texture}return V}function pt(P,T,V){return Math.floor(Math.floor(P/V)/T)}function Ut(P,T,V,ut){let yt=P.updateRanges;if(yt.length===0)n.texSubImage2D(e.TEXTURE_2D,0,0,0,T.width,T.height,V,ut,T.data);else{yt.sort((D,et)=>D.start-et.start);let Mt=0;for(let D=1;D<yt.length;D++){let et=yt[Mt],j=yt[D],vt=et.start+et.count,dt=pt(j.start,T.width,4),xt=pt(et.start,T.width,4);j.start<=vt+1&&dt===xt&&pt(j.start+j.count-1,T.width,4)===dt?et.count=Math.max(et.count,j.start+j.count-et.start):(++Mt,yt[Mt]=j)}yt.length=Mt+1;let Q=n.getParameter(e.UNPACK_ROW_LENGTH),tt=n.getParameter(e.UNPACK_SKIP_PIXELS),_t=n.getParameter(e.UNPACK_SKIP_ROWS);n.pixelStorei(e.UNPACK_ROW_LENGTH,T.width);for(let D=0,et=yt.length;D<et;D++){let j=yt[D],vt=Math.floor(j.start/4),dt=Math.ceil(j.count/4),xt=vt%T.width,Nt=Math.floor(vt/T.width),Yt=dt,ht=1;n.pixelStorei(e.UNPACK_SKIP_PIXELS,xt),n.pixelStorei(e.UNPACK_SKIP_ROWS,Nt),n.texSubImage2D(e.TEXTURE_2D,0,xt,Nt,Yt,ht,V,ut,T.data)}P.clearUpdateRanges(),n.pixelStorei(e.UNPACK_ROW_LENGTH,Q),n.pixelStorei(e.UNPACK_SKIP_PIXELS,tt),n.pixelStorei(e.UNPACK_SKIP_ROWS,_t)}}function Gt(P,T,V){let ut=e.TEXTURE_2D;(T.isDataArrayTexture||T.isCompressedArrayTexture)&&(ut=e.TEXTURE_2D_ARRAY),T.isData3DTexture&&(ut=e.TEXTURE_3D);let nt=It(P,T),yt=T.source;n.bindTexture(ut,P.__webglTexture,e.TEXTURE0+V);let Mt=i.get(yt);if(yt.version!==Mt.__version||nt===!0){if(n.activeTexture(e.TEXTURE0+V),(typeof ImageBitmap<"u"&&T.image instanceof ImageBitmap)===!1){let ht=ee.getPrimaries(ee.workingColorSpace),Dt=T.colorSpace===Nr?null:ee.getPrimaries(T.colorSpace),qt=T.colorSpace===Nr||ht===Dt?e.NONE:e.BROWSER_DEFAULT_WEBGL;n.pixelStorei(e.UNPACK_FLIP_Y_WEBGL,T.flipY),n.pixelStorei(e.UNPACK_PREMULTIPLY_ALPHA_WEBGL,T.premultiplyAlpha),n.pixelStorei(e.UNPACK_COLORSPACE_CONVERSION_WEBGL,qt)}n.pixelStorei(e.UNPACK_ALIGNMENT,T.unpackAlignment);let tt=v(T.image,!1,r.maxTextureSize);tt=Lt(T,tt);let _t=s.convert(T.format,T.colorSpace),D=s.convert(T.type),et=b(T.internalFormat,_t,D,T.normalized,T.colorSpace,T.isVideoTexture);K(ut,T);let j,vt=T.mipmaps,dt=T.isVideoTexture!==!0,xt=Mt.__version===void 0||nt===!0,Nt=yt.dataReady,Yt=M(T,tt);if(T.isDepthTexture)et=x(T.format===Lr,T.type),xt&&(dt?n.texStorage2D(e.TEXTURE_2D,1,et,tt.width,tt.height):n.texImage2D(e.TEXTURE_2D,0,et,tt.width,tt.height,0,_t,D,null));else if(T.isDataTexture)if(vt.length>0){dt&&xt&&n.texStorage2D(e.TEXTURE_2D,Yt,et,vt[0].width,vt[0].height);for(let ht=0,Dt=vt.length;ht<Dt;ht++)j=vt[ht],dt?Nt&&n.texSubImage2D(e.TEXTURE_2D,ht,0,0,j.width,j.height,_t,D,j.data):n.texImage2D(e.TEXTURE_2D,ht,et,j.width,j.height,0,_t,D,j.data);T.generateMipmaps=!1}else dt?(xt&&n.texStorage2D(e.TEXTURE_2D,Yt,et,tt.width,tt.height),Nt&&Ut(T,tt,_t,D)):n.texImage2D(e.TEXTURE_2D,0,et,tt.width,tt.height,0,_t,D,tt.data);else if(T.isCompressedTexture)if(T.isCompressedArrayTexture){dt&&xt&&n.texStorage3D(e.TEXTURE_2D_ARRAY,Yt,et,vt[0].width,vt[0].height,tt.depth);for(let ht=0,Dt=vt.length;ht<Dt;ht++)if(j=vt[ht],T.format!==Pi)if(_t!==null)if(dt){if(Nt)if(T.layerUpdates.size>0){let qt=Rm(j.width,j.height,T.format,T.type);for(let wt of T.layerUpdates){let he=j.data.subarray(wt*qt/j.data.BYTES_PER_ELEMENT,(wt+1)*qt/j.data.BYTES_PER_ELEMENT);n.compressedTexSubImage3D(e.TEXTURE_2D_ARRAY,ht,0,0,wt,j.width,j.height,1,_t,he)}}else n.compressedTexSubImage3D(e.TEXTURE_2D_ARRAY,ht,0,0,0,j.width,j.height,tt.depth,_t,j.data)}else n.compressedTexImage3D(e.TEXTURE_2D_ARRAY,ht,et,j.width,j.height,tt.depth,0,j.data,0,0);else Ft("WebGLRenderer: Attempt to load unsupported compressed texture format in .uploadTexture()");else dt?Nt&&n.texSubImage3D(e.TEXTURE_2D_ARRAY,ht,0,0,0,j.width,j.height,tt.depth,_t,D,j.data):n.texImage3D(e.TEXTURE_2D_ARRAY,ht,et,j.width,j.height,tt.depth,0,_t,D,j.data);T.layerUpdates.size>0&&T.clearLayerUpdates()}else{dt&&xt&&n.texStorage2D(e.TEXTURE_2D,Yt,et,vt[0].width,vt[0].height);for(let ht=0,Dt=vt.length;ht<Dt;ht++)j=vt[ht],T.format!==Pi?_t!==null?dt?Nt&&n.compressedTexSubImage2D(e.TEXTURE_2D,ht,0,0,j.width,j.height,_t,j.data):n.compressedTexImage2D(e.TEXTURE_2D,ht,et,j.width,j.height,0,j.data):Ft("WebGLRenderer: Attempt to load unsupported compressed texture format in .uploadTexture()"):dt?Nt&&n.texSubImage2D(e.TEXTURE_2D,ht,0,0,j.width,j.height,_t,D,j.data):n.texImage2D(e.TEXTURE_2D,ht,et,j.width,j.height,0,_t,D,j.data)}else if(T.isDataArrayTexture)if(dt){if(xt&&n.texStorage3D(e.TEXTURE_2D_ARRAY,Yt,et,tt.width,tt.height,tt.depth),Nt)if(T.layerUpdates.size>0){let ht=Rm(tt.width,tt.height,T.format,T.type);for(let Dt of T.layerUpdates){let qt=tt.data.subarray(Dt*ht/tt.data.BYTES_PER_ELEMENT,(Dt+1)*ht/tt.data.BYTES_PER_ELEMENT);n.texSubImage3D(e.TEXTURE_2D_ARRAY,0,0,0,Dt,tt.width,tt.height,1,_t,D,qt)}T.clearLayerUpdates()}else n.texSubImage3D(e.TEXTURE_2D_ARRAY,0,0,0,0,tt.width,tt.height,tt.depth,_t,D,tt.data)}else n.texImage3D(e.TEXTURE_2D_ARRAY,0,et,tt.width,tt.height,tt.depth,0,_t,D,tt.data);else if(T.isData3DTexture)dt?(xt&&n.texStorage3D(e.TEXTURE_3D,Yt,et,tt.width,tt.height,tt.depth),Nt&&n.texSubImage3D(e.TEXTURE_3D,0,0,0,0,tt.width,tt.height,tt.depth,_t,D,tt.data)):n.texImage3D(e.TEXTURE_3D,0,et,tt.width,tt.height,tt.depth,0,_t,D,tt.data);else if(T.isFramebufferTexture){if(xt)if(dt)n.texStorage2D(e.TEXTURE_2D,Yt,et,tt.width,tt.height);else{let ht=tt.width,Dt=tt.height;for(let qt=0;qt<Yt;qt++)n.texImage2D(e.TEXTURE_2D,qt,et,ht,Dt,0,_t,D,null),ht>>=1,Dt>>=1}}else if(T.isHTMLTexture){if("texElementImage2D"in e){let ht=e.canvas;if(ht.hasAttribute("layoutsubtree")||ht.setAttribute("layoutsubtree","true"),tt.parentNode!==ht){ht.appendChild(tt),h.add(T),ht.onpaint=Dt=>{let qt=Dt.changedElements;for(let wt of h)qt.includes(wt.image)&&(wt.needsUpdate=!0)},ht.requestPaint();return}if(e.texElementImage2D.length===3)e.texElementImage2D(e.TEXTURE_2D,e.RGBA8,tt);else{let qt=e.RGBA,wt=e.RGBA,he=e.UNSIGNED_BYTE;e.texElementImage2D(e.TEXTURE_2D,0,qt,wt,he,tt)}e.texParameteri(e.TEXTURE_2D,e.TEXTURE_MIN_FILTER,e.LINEAR),e.texParameteri(e.TEXTURE_2D,e.TEXTURE_WRAP_S,e.CLAMP_TO_EDGE),e.texParameteri(e.TEXTURE_2D,e.TEXTURE_WRAP_T,e.CLAMP_TO_EDGE)}}else if(vt.length>0){if(dt&&xt){let ht=Bt(vt[0]);n.texStorage2D(e.TEXTURE_2D,Yt,et,ht.width,ht.height)}for(let ht=0,Dt=vt.length;ht<Dt;ht++)j=vt[ht],dt?Nt&&n.texSubImage2D(e.TEXTURE_2D,ht,0,0,_t,D,j):n.texImage2D(e.TEXTURE_2D,ht,et,_t,D,j);T.generateMipmaps=!1}else if(dt){if(xt){let ht=Bt(tt);n.texStorage2D(e.TEXTURE_2D,Yt,et,ht.width,ht.height)}Nt&&n.texSubImage2D(e.TEXTURE_2D,0,0,0,_t,D,tt)}else n.texImage2D(e.TEXTURE_2D,0,et,_t,D,tt);S(T)&&T.mipmapsAutoUpdate===!0&&_(ut),Mt.__version=yt.version,T.onUpdate&&T.onUpdate(T)}P.__version=T.version}function ce(P,T,V){if(T.image.length!==6)return;let ut=It(P,T),nt=T.source;n.bindTexture(e.TEXTURE_CUBE_MAP,P.__webglTexture,e.TEXTURE0+V);let yt=i.get(nt);if(nt.version!==yt.__version||ut===!0){n.activeTexture(e.TEXTURE0+V);let Mt=ee.getPrimaries(ee.workingColorSpace),Q=T.colorSpace===Nr?null:ee.getPrimaries(T.colorSpace),tt=T.colorSpace===Nr||Mt===Q?e.NONE:e.BROWSER_DEFAULT_WEBGL;n.pixelStorei(e.UNPACK_FLIP_Y_WEBGL,T.flipY),n.pixelStorei(e.UNPACK_PREMULTIPLY_ALPHA_WEBGL,T.premultiplyAlpha),n.pixelStorei(e.UNPACK_ALIGNMENT,T.unpackAlignment),n.pixelStorei(e.UNPACK_COLORSPACE_CONVERSION_WEBGL,tt);let _t=T.isCompressedTexture||T.image[0].isCompressedTexture,D=T.image[0]&&T.image[0].isDataTexture,et=[];for(let wt=0;wt<6;wt++)!_t&&!D?et[wt]=v(T.image[wt],!0,r.maxCubemapSize):et[wt]=D?T.image[wt].image:T.image[wt],et[wt]=Lt(T,et[wt]);let j=et[0],vt=s.convert(T.format,T.colorSpace),dt=s.convert(T.type),xt=b(T.internalFormat,vt,dt,T.normalized,T.colorSpace),Nt=T.isVideoTexture!==!0,Yt=yt.__version===void 0||ut===!0,ht=nt.dataReady,Dt=M(T,j);K(e.TEXTURE_CUBE_MAP,T);let qt;if(T.isDepthTexture){if(xt=x(T.format===Lr,T.type),Yt)if(Nt)n.texStorage2D(e.TEXTURE_CUBE_MAP,1,xt,j.width,j.height);else for(let wt=0;wt<6;wt++)n.texImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,0,xt,j.width,j.height,0,vt,dt,null)}else if(_t){Nt&&Yt&&n.texStorage2D(e.TEXTURE_CUBE_MAP,Dt,xt,j.width,j.height);for(let wt=0;wt<6;wt++){qt=et[wt].mipmaps;for(let he=0;he<qt.length;he++){let qe=qt[he];T.format!==Pi?vt!==null?Nt?ht&&n.compressedTexSubImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he,0,0,qe.width,qe.height,vt,qe.data):n.compressedTexImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he,xt,qe.width,qe.height,0,qe.data):Ft("WebGLRenderer: Attempt to load unsupported compressed texture format in .setTextureCube()"):Nt?ht&&n.texSubImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he,0,0,qe.width,qe.height,vt,dt,qe.data):n.texImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he,xt,qe.width,qe.height,0,vt,dt,qe.data)}}}else{if(qt=T.mipmaps,Nt&&Yt){qt.length>0&&Dt++;let wt=Bt(et[0]);n.texStorage2D(e.TEXTURE_CUBE_MAP,Dt,xt,wt.width,wt.height)}for(let wt=0;wt<6;wt++)if(D){Nt?ht&&n.texSubImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,0,0,0,et[wt].width,et[wt].height,vt,dt,et[wt].data):n.texImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,0,xt,et[wt].width,et[wt].height,0,vt,dt,et[wt].data);for(let he=0;he<qt.length;he++){let is=qt[he].image[wt].image;Nt?ht&&n.texSubImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he+1,0,0,is.width,is.height,vt,dt,is.data):n.texImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he+1,xt,is.width,is.height,0,vt,dt,is.data)}}else{Nt?ht&&n.texSubImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,0,0,0,vt,dt,et[wt]):n.texImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,0,xt,vt,dt,et[wt]);for(let he=0;he<qt.length;he++){let qe=qt[he];Nt?ht&&n.texSubImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he+1,0,0,vt,dt,qe.image[wt]):n.texImage2D(e.TEXTURE_CUBE_MAP_POSITIVE_X+wt,he+1,xt,vt,dt,qe.image[wt])}}}S(T)&&T.mipmapsAutoUpdate===!0&&_(e.TEXTURE_CUBE_MAP),yt.__version=nt.version,T.onUpdate&&T.onUpdate(T)}P.__version=T.version}function oe(P,T,V,ut,nt,yt){let Mt=s.convert(V.format,V.colorSpace),Q=s.convert(V.type),tt=b(V.internalFormat,Mt,Q,V.normalized,V.colorSpace),_t=i.get(T),D=i.get(V);if(D.__renderTarget=T,!_t.__hasExternalTextures){let et=Math.max(1,T.width>>yt),j=Math.max(1,T.height>>yt);nt===e.TEXTURE_3D||nt===e.TEXTURE_2D_ARRAY?n.texImage3D(nt,yt,tt,et,j,T.depth,0,Mt,Q,null):n.texImage2D(nt,yt,tt,et,j,0,Mt,Q,null)}n.bindFramebuffer(e.FRAMEBUFFER,P),mt(T)?a.framebufferTexture2DMultisampleEXT(e.FRAMEBUFFER,ut,nt,D.__webglTexture,0,ve(T)):(nt===e.TEXTURE_2D||nt>=e.TEXTURE_CUBE_MAP_POSITIVE_X&&nt<=e.TEXTURE_CUBE_MAP_NEGATIVE_Z)&&e.framebufferTexture2D(e.FRAMEBUFFER,ut,nt,D.__webglTexture,yt),n.bindFramebuffer(e.FRAMEBUFFER,null)}function Xe(P,T,V){if(e.bindRenderbuffer(e.RENDERBUFFER,P),T.depthBuffer){let ut=T.depthTexture,nt=ut&&ut.isDepthTexture?ut.type:null,yt=x(T.stencilBuffer,nt),Mt=T.stencilBuffer?e.DEPTH_STENCIL_ATTACHMENT:e.DEPTH_ATTACHMENT;mt(T)?a.renderbufferStorageMultisampleEXT(e.RENDERBUFFER,ve(T),yt,T.width,T.height):V?e.renderbufferStorageMultisample(e.RENDERBUFFER,ve(T),yt,T.width,T.height):e.renderbufferStorage(e.RENDERBUFFER,yt,T.width,T.height),e.framebufferRenderbuffer(e.FRAMEBUFFER,Mt,e.RENDERBUFFER,P)}else{let ut=T.textures;for(let nt=0;nt<ut.length;nt++){let yt=ut[nt],Mt=s.convert(yt.format,yt.colorSpace),Q=s.convert(yt.type),tt=b(yt.internalFormat,Mt,Q,yt.normalized,yt.colorSpace);mt(T)?a.renderbufferStorageMultisampleEXT(e.RENDERBUFFER,ve(T),tt,T.width,T.height):V?e.renderbufferStorageMultisample(e.RENDERBUFFER,ve(T),tt,T.width,T.height):e.renderbufferStorage(e.RENDERBUFFER,tt,T.width,T.height)}}e.bindRenderbuffer(e.RENDERBUFFER,null)}function Be(P,T,V){let ut=T.isWebGLCubeRenderTarget===!0;if(n.bindFramebuffer(e.FRAMEBUFFER,P),!(T.depthTexture&&T.depthTexture.isDepthTexture))throw new Error("THREE.WebGLTextures: renderTarget.depthTexture must be an instance of THREE.DepthTexture.");let nt=i.get(T.depthTexture);nt.__renderTarget=T;let yt=ut?T.depthTexture.image[0]:T.depthTexture.image;(!nt.__webglTexture||yt.width!==T.width||yt.height!==T.height)&&(yt.width=T.width,yt.height=T.height,T.depthTexture.needsUpdate=!0),ut?rt(T.depthTexture,0):at(T.depthTexture,0);let Mt=nt.__webglTexture,Q=ve(T),tt=ut?e.TEXTURE_CUBE_MAP_POSITIVE_X+V:e.TEXTURE_2D,_t=T.depthTexture.format===Lr?e.DEPTH_STENCIL_ATTACHMENT:e.DEPTH_ATTACHMENT;if(T.depthTexture.format===Cr)mt(T)?a.framebufferTexture2DMultisampleEXT(e.FRAMEBUFFER,_t,tt,Mt,0,Q):e.framebufferTexture2D(e.FRAMEBUFFER,_t,tt,Mt,0);else if(T.depthTexture.format===Lr)mt(T)?a.framebufferTexture2DMultisampleEXT(e.FRAMEBUFFER,_t,tt,Mt,0,Q):e.framebufferTexture2D(e.FRAMEBUFFER,_t,tt,Mt,0);else throw new Error("THREE.WebGLTextures: Unknown depthTexture format.")}function Ln(P){let T=i.get(P),V=P.isWebGLCubeRenderTarget===!0;if(T.__boundDepthTexture!==P.depthTexture){let ut=P.depthTexture;if(T.__depthDisposeCallback&&T.__depthDisposeCallback(),ut){let nt=()=>{delete T.__boundDepthTexture,delete T.__depthDisposeCallback,ut.removeEventListener("dispose",nt)};ut.addEventListener("dispose",nt),T.__depthDisposeCallback=nt}T.__boundDepthTexture=ut}if(P.depthTexture&&!T.__autoAllocateDepthBuffer)if(V)for(let ut=0;ut<6;ut++)Be(T.__webglFramebuffer[ut],P,ut);else P.texture.mipmaps.length>0?Be(T.__webglFramebuffer[0],P,0):Be(T.__webglFramebuffer,P,0);else if(V){T.__webglDepthbuffer=[];for(let ut=0;ut<6;ut++)if(n.bindFramebuffer(e.FRAMEBUFFER,T.__webglFramebuffer[ut]),T.__webglDepthbuffer[ut]===void 0)T.__webglDepthbuffer[ut]=e.createRenderbuffer(),Xe(T.__webglDepthbuffer[ut],P,!1);else{let nt=P.stencilBuffer?e.DEPTH_STENCIL_ATTACHMENT:e.DEPTH_ATTACHMENT,yt=T.__webglDepthbuffer[ut];e.bindRenderbuffer(e.RENDERBUFFER,yt),e.framebufferRenderbuffer(e.FRAMEBUFFER,nt,e.RENDERBUFFER,yt)}}else if(P.texture.mipmaps.length>0?n.bindFramebuffer(e.FRAMEBUFFER,T.__webglFramebuffer[0]):n.bindFramebuffer(e.FRAMEBUFFER,T.__webglFramebuffer),T.__webglDepthbuffer===void 0)T.__webglDepthbuffer=e.createRenderbuffer(),Xe(T.__webglDepthbuffer,P,!1);else{let nt=P.stencilBuffer?e.DEPTH_STENCIL_ATTACHMENT:e.DEPTH_ATTACHMENT,yt=T.__webglDepthbuffer;e.bindRenderbuffer(e.RENDERBUFFER,yt),e.framebufferRenderbuffer(e.FRAMEBUFFER,nt,e.RENDERBUFFER,yt)}n.bindFramebuffer(e.FRAMEBUFFER,null)}function xn(P,T,V){let ut=i.get(P);T!==void 0&&oe(ut.__webglFramebuffer,P,P.texture,e.COLOR_ATTACHMENT0,e.TEXTURE_2D,0),V!==void 0&&Ln(P)}function Nn(P){let T=P.texture,V=i.get(P),ut=i.get(T);P.addEventListener("dispose",N),R(P);let nt=P.textures,yt=P.isWebGLCubeRenderTarget===!0,Mt=nt.length>1;if(Mt||(ut.__webglTexture===void 0&&(ut.__webglTexture=e.createTexture()),ut.__version=T.version,o.memory.textures++),yt){V.__webglFramebuffer=[];for(let Q=0;Q<6;Q++)if(T.mipmaps.length>0){V.__webglFramebuffer[Q]=[];for(let tt=0;tt<T.mipmaps.length;tt++)V.__webglFramebuffer[Q][tt]=e.createFramebuffer()}else V.__webglFramebuffer[Q]=e.createFramebuffer()}else{if(T.mipmaps.length>0){V.__webglFramebuffer=[];for(let Q=0;Q<T.mipmaps.length;Q++)V.__webglFramebuffer[Q]=e.createFramebuffer()}else V.__webglFramebuffer=e.createFramebuffer();if(Mt)for(let Q=0,tt=nt.length;Q<tt;Q++){let _t=i.get(nt[Q]);_t.__webglTexture===void 0&&(_t.__webglTexture=e.createTexture(),o.memory.textures++)}if(P.samples>0&&mt(P)===!1){V.__webglMultisampledFramebuffer=e.createFramebuffer(),V.__webglColorRenderbuffer=[],n.bindFramebuffer(e.FRAMEBUFFER,V.__webglMultisampledFramebuffer);for(let Q=0;Q<nt.length;Q++){let tt=nt[Q];V.__webglColorRenderbuffer[Q]=e.createRenderbuffer(),e.bindRenderbuffer(e.RENDERBUFFER,V.__webglColorRenderbuffer[Q]);let _t=s.convert(tt.format,tt.colorSpace),D=s.convert(tt.type),et=b(tt.internalFormat,_t,D,tt.normalized,tt.colorSpace,P.isXRRenderTarget===!0),j=ve(P);e.renderbufferStorageMultisample(e.RENDERBUFFER,j,et,P.width,P.height),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0+Q,e.RENDERBUFFER,V.__webglColorRenderbuffer[Q])}e.bindRenderbuffer(e.RENDERBUFFER,null),P.depthBuffer&&(V.__webglDepthRenderbuffer=e.createRenderbuffer(),Xe(V.__webglDepthRenderbuffer,P,!0)),n.bindFramebuffer(e.FRAMEBUFFER,null)}}if(yt){n.bindTexture(e.TEXTURE_CUBE_MAP,ut.__webglTexture),K(e.TEXTURE_CUBE_MAP,T);for(let Q=0;Q<6;Q++)if(T.mipmaps.length>0)for(let tt=0;tt<T.mipmaps.length;tt++)oe(V.__webglFramebuffer[Q][tt],P,T,e.COLOR_ATTACHMENT0,e.TEXTURE_CUBE_MAP_POSITIVE_X+Q,tt);else oe(V.__webglFramebuffer[Q],P,T,e.COLOR_ATTACHMENT0,e.TEXTURE_CUBE_MAP_POSITIVE_X+Q,0);S(T)?_(e.TEXTURE_CUBE_MAP):T.mipmaps.length>0&&e.texParameteri(e.TEXTURE_CUBE_MAP,e.TEXTURE_MAX_LEVEL,T.mipmaps.length-1),n.unbindTexture()}else if(Mt){for(let Q=0,tt=nt.length;Q<tt;Q++){let _t=nt[Q],D=i.get(_t),et=e.TEXTURE_2D;(P.isWebGL3DRenderTarget||P.isWebGLArrayRenderTarget)&&(et=P.isWebGL3DRenderTarget?e.TEXTURE_3D:e.TEXTURE_2D_ARRAY),n.bindTexture(et,D.__webglTexture),K(et,_t),oe(V.__webglFramebuffer,P,_t,e.COLOR_ATTACHMENT0+Q,et,0),S(_t)&&_(et)}n.unbindTexture()}else{let Q=e.TEXTURE_2D;if((P.isWebGL3DRenderTarget||P.isWebGLArrayRenderTarget)&&(Q=P.isWebGL3DRenderTarget?e.TEXTURE_3D:e.TEXTURE_2D_ARRAY),n.bindTexture(Q,ut.__webglTexture),K(Q,T),T.mipmaps.length>0)for(let tt=0;tt<T.mipmaps.length;tt++)oe(V.__webglFramebuffer[tt],P,T,e.COLOR_ATTACHMENT0,Q,tt);else oe(V.__webglFramebuffer,P,T,e.COLOR_ATTACHMENT0,Q,0);S(T)?_(Q):T.mipmaps.length>0&&e.texParameteri(Q,e.TEXTURE_MAX_LEVEL,T.mipmaps.length-1),n.unbindTexture()}P.depthBuffer&&Ln(P)}function z(P){let T=P.textures;for(let V=0,ut=T.length;V<ut;V++){let nt=T[V];if(S(nt)&&nt.mipmapsAutoUpdate===!0){let yt=w(P),Mt=i.get(nt).__webglTexture;n.bindTexture(yt,Mt),_(yt),n.unbindTexture()}}}let Dn=[];function _e(P){if(P.samples>0){if(mt(P)===!1){let T=P.textures,V=P.width,ut=P.height,nt=e.COLOR_BUFFER_BIT,yt=P.stencilBuffer?e.DEPTH_STENCIL_ATTACHMENT:e.DEPTH_ATTACHMENT,Mt=i.get(P),Q=T.length>1;if(Q)for(let _t=0;_t<T.length;_t++)n.bindFramebuffer(e.FRAMEBUFFER,Mt.__webglMultisampledFramebuffer),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0+_t,e.RENDERBUFFER,null),n.bindFramebuffer(e.FRAMEBUFFER,Mt.__webglFramebuffer),e.framebufferTexture2D(e.DRAW_FRAMEBUFFER,e.COLOR_ATTACHMENT0+_t,e.TEXTURE_2D,null,0);n.bindFramebuffer(e.READ_FRAMEBUFFER,Mt.__webglMultisampledFramebuffer),P.texture.mipmaps.length>0?n.bindFramebuffer(e.DRAW_FRAMEBUFFER,Mt.__webglFramebuffer[0]):n.bindFramebuffer(e.DRAW_FRAMEBUFFER,Mt.__webglFramebuffer);for(let _t=0;_t<T.length;_t++){if(P.resolveDepthBuffer&&(P.depthBuffer&&(nt|=e.DEPTH_BUFFER_BIT),P.stencilBuffer&&P.resolveStencilBuffer&&(nt|=e.STENCIL_BUFFER_BIT)),Q){e.framebufferRenderbuffer(e.READ_FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.RENDERBUFFER,Mt.__webglColorRenderbuffer[_t]);let D=i.get(T[_t]).__webglTexture;e.framebufferTexture2D(e.DRAW_FRAMEBUFFER,e.COLOR_ATTACHMENT0,e.TEXTURE_2D,D,0)}e.blitFramebuffer(0,0,V,ut,0,0,V,ut,nt,e.NEAREST),c===!0&&(Dn.length=0,Dn.push(e.COLOR_ATTACHMENT0+_t),P.depthBuffer&&P.storeMultisampledDepthBuffer===!1&&Dn.push(yt),e.invalidateFramebuffer(e.READ_FRAMEBUFFER,Dn))}if(n.bindFramebuffer(e.READ_FRAMEBUFFER,null),n.bindFramebuffer(e.DRAW_FRAMEBUFFER,null),Q)for(let _t=0;_t<T.length;_t++){n.bindFramebuffer(e.FRAMEBUFFER,Mt.__webglMultisampledFramebuffer),e.framebufferRenderbuffer(e.FRAMEBUFFER,e.COLOR_ATTACHMENT0+_t,e.RENDERBUFFER,Mt.__webglColorRenderbuffer[_t]);let D=i.get(T[_t]).__webglTexture;n.bindFramebuffer(e.FRAMEBUFFER,Mt.__webglFramebuffer),e.framebufferTexture2D(e.DRAW_FRAMEBUFFER,e.COLOR_ATTACHMENT0+_t,e.TEXTURE_2D,D,0)}n.bindFramebuffer(e.DRAW_FRAMEBUFFER,Mt.__webglMultisampledFramebuffer)}else if(P.depthBuffer&&P.storeMultisampledDepthBuffer===!1&&c){let T=P.stencilBuffer?e.DEPTH_STENCIL_ATTACHMENT:e.DEPTH_ATTACHMENT;e.invalidateFramebuffer(e.DRAW_FRAMEBUFFER,[T])}}}function ve(P){return Math.min(r.maxSamples,P.samples)}function mt(P){let T=i.get(P);return P.samples>0&&t.has("WEBGL_multisampled_render_to_texture")===!0&&T.__useRenderToTexture!==!1}function Ce(P){let T=o.render.frame;u.get(P)!==T&&(u.set(P,T),P.update())}function Lt(P,T){let V=P.colorSpace,ut=P.format,nt=P.type;return P.isCompressedTexture===!0||P.isVideoTexture===!0||V!==vc&&V!==Nr&&(ee.getTransfer(V)===ue?(ut!==Pi||nt!==On)&&Ft("WebGLTextures: sRGB encoded textures have to use RGBAFormat and UnsignedByteType."):kt("WebGLTextures: Unsupported texture color space:",V)),T}function Bt(P){return typeof HTMLImageElement<"u"&&P instanceof HTMLImageElement?(l.width=P.naturalWidth||P.width,l.height=P.naturalHeight||P.height):typeof VideoFrame<"u"&&P instanceof VideoFrame?(l.width=P.displayWidth,l.height=P.displayHeight):(l.width=P.width,l.height=P.height),l}this.allocateTextureUnit=ct,this.resetTextureUnits=G,this.getTextureUnits=q,this.setTextureUnits=st,this.setTexture2D=at,this.setTexture2DArray=ft,this.setTexture3D=ot,this.setTextureCube=rt,this.rebindTextures=xn,this.setupRenderTarget=Nn,this.updateRenderTargetMipmap=z,this.updateMultisampleRenderTarget=_e,this.setupDepthRenderbuffer=Ln,this.setupFrameBufferTexture=oe,this.useMultisampledRTT=mt,this.dispose=L}function oN(e,t){function n(i,r=Nr){let s,o=ee.getTransfer(r);if(i===On)return e.UNSIGNED_BYTE;if(i===yf)return e.UNSIGNED_SHORT_4_4_4_4;if(i===xf)return e.UNSIGNED_SHORT_5_5_5_1;if(i===hm)return e.UNSIGNED_INT_5_9_9_9_REV;if(i===dm)return e.UNSIGNED_INT_10F_11F_11F_REV;if(i===um)return e.BYTE;if(i===fm)return e.SHORT;if(i===sa)return e.UNSIGNED_SHORT;if(i===gf)return e.INT;if(i===Ci)return e.UNSIGNED_INT;if(i===Ri)return e.FLOAT;if(i===Ii)return e.HALF_FLOAT;if(i===pm)return e.ALPHA;if(i===mm)return e.RGB;if(i===Pi)return e.RGBA;if(i===Cr)return e.DEPTH_COMPONENT;if(i===Lr)return e.DEPTH_STENCIL;if(i===gm)return e.RED;if(i===_f)return e.RED_INTEGER;if(i===xs)return e.RG;if(i===vf)return e.RG_INTEGER;if(i===bf)return e.RGBA_INTEGER;if(i===Gc||i===Vc||i===Hc||i===Wc)if(o===ue)if(s=t.get("WEBGL_compressed_texture_s3tc_srgb"),s!==null){if(i===Gc)return s.COMPRESSED_SRGB_S3TC_DXT1_EXT;if(i===Vc)return s.COMPRESSED_SRGB_ALPHA_S3TC_DXT1_EXT;if(i===Hc)return s.COMPRESSED_SRGB_ALPHA_S3TC_DXT3_EXT;if(i===Wc)return s.COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT}else return null;else if(s=t.get("WEBGL_compressed_texture_s3tc"),s!==null){if(i===Gc)return s.COMPRESSED_RGB_S3TC_DXT1_EXT;if(i===Vc)return s.COMPRESSED_RGBA_S3TC_DXT1_EXT;if(i===Hc)return s.COMPRESSED_RGBA_S3TC_DXT3_EXT;if(i===Wc)return s.COMPRESSED_RGBA_S3TC_DXT5_EXT}else return null;if(i===Mf||i===Sf||i===wf||i===Tf)if(s=t.get("WEBGL_compressed_texture_pvrtc"),s!==null){if(i===Mf)return s.COMPRESSED_RGB_PVRTC_4BPPV1_IMG;if(i===Sf)return s.COMPRESSED_RGB_PVRTC_2BPPV1_IMG;if(i===wf)return s.COMPRESSED_RGBA_PVRTC_4BPPV1_IMG;if(i===Tf)return s.COMPRESSED_RGBA_PVRTC_2BPPV1_IMG}else return null;if(i===Af||i===Ef||i===Cf||i===Rf||i===If||i===$c||i===Pf)if(s=t.get("WEBGL_compressed_texture_etc"),s!==null){if(i===Af||i===Ef)return o===ue?s.COMPRESSED_SRGB8_ETC2:s.COMPRESSED_RGB8_ETC2;if(i===Cf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ETC2_EAC:s.COMPRESSED_RGBA8_ETC2_EAC;if(i===Rf)return s.COMPRESSED_R11_EAC;if(i===If)return s.COMPRESSED_SIGNED_R11_EAC;if(i===$c)return s.COMPRESSED_RG11_EAC;if(i===Pf)return s.COMPRESSED_SIGNED_RG11_EAC}else return null;if(i===Lf||i===Nf||i===Df||i===Ff||i===Uf||i===Of||i===Bf||i===kf||i===zf||i===Gf||i===Vf||i===Hf||i===Wf||i===$f)if(s=t.get("WEBGL_compressed_texture_astc"),s!==null){if(i===Lf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_4x4_KHR:s.COMPRESSED_RGBA_ASTC_4x4_KHR;if(i===Nf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_5x4_KHR:s.COMPRESSED_RGBA_ASTC_5x4_KHR;if(i===Df)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_5x5_KHR:s.COMPRESSED_RGBA_ASTC_5x5_KHR;if(i===Ff)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_6x5_KHR:s.COMPRESSED_RGBA_ASTC_6x5_KHR;if(i===Uf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_6x6_KHR:s.COMPRESSED_RGBA_ASTC_6x6_KHR;if(i===Of)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_8x5_KHR:s.COMPRESSED_RGBA_ASTC_8x5_KHR;if(i===Bf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_8x6_KHR:s.COMPRESSED_RGBA_ASTC_8x6_KHR;if(i===kf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_8x8_KHR:s.COMPRESSED_RGBA_ASTC_8x8_KHR;if(i===zf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_10x5_KHR:s.COMPRESSED_RGBA_ASTC_10x5_KHR;if(i===Gf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_10x6_KHR:s.COMPRESSED_RGBA_ASTC_10x6_KHR;if(i===Vf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_10x8_KHR:s.COMPRESSED_RGBA_ASTC_10x8_KHR;if(i===Hf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_10x10_KHR:s.COMPRESSED_RGBA_ASTC_10x10_KHR;if(i===Wf)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_12x10_KHR:s.COMPRESSED_RGBA_ASTC_12x10_KHR;if(i===$f)return o===ue?s.COMPRESSED_SRGB8_ALPHA8_ASTC_12x12_KHR:s.COMPRESSED_RGBA_ASTC_12x12_KHR}else return null;if(i===Xf||i===qf||i===Yf)if(s=t.get("EXT_texture_compression_bptc"),s!==null){if(i===Xf)return o===ue?s.COMPRESSED_SRGB_ALPHA_BPTC_UNORM_EXT:s.COMPRESSED_RGBA_BPTC_UNORM_EXT;if(i===qf)return s.COMPRESSED_RGB_BPTC_SIGNED_FLOAT_EXT;if(i===Yf)return s.COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT_EXT}else return null;if(i===Zf||i===Jf||i===Xc||i===Kf)if(s=t.get("EXT_texture_compression_rgtc"),s!==null){if(i===Zf)return s.COMPRESSED_RED_RGTC1_EXT;if(i===Jf)return s.COMPRESSED_SIGNED_RED_RGTC1_EXT;if(i===Xc)return s.COMPRESSED_RED_GREEN_RGTC2_EXT;if(i===Kf)return s.COMPRESSED_SIGNED_RED_GREEN_RGTC2_EXT}else return null;return i===js?e.UNSIGNED_INT_24_8:e[i]!==void 0?e[i]:null}return{convert:n}}var aN=`
void main() {

	gl_Position = vec4( position, 1.0 );

}`,cN=`
uniform sampler2DArray depthColor;
uniform float depthWidth;
uniform float depthHeight;

void main() {

	vec2 coord = vec2( gl_FragCoord.x / depthWidth, gl_FragCoord.y / depthHeight );

	if ( coord.x >= 1.0 ) {

		gl_FragDepth = texture( depthColor, vec3( coord.x - 1.0, coord.y, 1 ) ).r;

	} else {

		gl_FragDepth = texture( depthColor, vec3( coord.x, coord.y, 0 ) ).r;

	}

}`,Bm=class{constructor(){this.texture=null,this.mesh=null,this.depthNear=0,this.depthFar=0}init(t,n){if(this.texture===null){let i=new Ic(t.texture);(t.depthNear!==n.depthNear||t.depthFar!==n.depthFar)&&(this.depthNear=t.depthNear,this.depthFar=t.depthFar),this.texture=i}}getMesh(t){if(this.texture!==null&&this.mesh===null){let n=t.cameras[0].viewport,i=new qi({vertexShader:aN,fragmentShader:cN,uniforms:{depthColor:{value:this.texture},depthWidth:{value:n.z},depthHeight:{value:n.w}}});this.mesh=new Yn(new Ys(20,20),i)}return this.mesh}reset(){this.texture=null,this.mesh=null}getDepthTexture(){return this.texture}},km=class extends Xi{constructor(t,n){super();let i=this,r=null,s=1,o=null,a="local-floor",c=1,l=null,u=null,h=null,f=null,d=null,p=null,y=typeof XRWebGLBinding<"u",m=new Bm,g={},v=n.getContextAttributes(),S=null,_=null,w=[],b=[],x=new ie,M=null,R=null,E=new vn;E.viewport=new Te;let C=new vn;C.viewport=new Te;let N=[E,C],B=new ff,I=null,L=null;this.cameraAutoUpdate=!0,this.enabled=!1,this.isPresenting=!1,this.getController=function($){let at=w[$];return at===void 0&&(at=new jo,w[$]=at),at.getTargetRaySpace()},this.getControllerGrip=function($){let at=w[$];return at===void 0&&(at=new jo,w[$]=at),at.getGripSpace()},this.getHand=function($){let at=w[$];return at===void 0&&(at=new jo,w[$]=at),at.getHandSpace()};function k($){let at=b.indexOf($.inputSource);if(at===-1)return;let ft=w[at];ft!==void 0&&(ft.update($.inputSource,$.frame,l||o),ft.dispatchEvent({type:$.type,data:$.inputSource}))}function F(){r.removeEventListener("select",k),r.removeEventListener("selectstart",k),r.removeEventListener("selectend",k),r.removeEventListener("squeeze",k),r.removeEventListener("squeezestart",k),r.removeEventListener("squeezeend",k),r.removeEventListener("end",F),r.removeEventListener("inputsourceschange",Z);for(let $=0;$<w.length;$++){let at=b[$];at!==null&&(b[$]=null,w[$].disconnect(at))}I=null,L=null,m.reset();for(let $ in g)delete g[$];if(t.setRenderTarget(S),d=null,f=null,h=null,r=null,_=null,ct.stop(),i.isPresenting=!1,t.setPixelRatio(M),t.setSize(x.width,x.height,!1),R!==null){let $=R.camera;$.fov=R.fov,$.zoom=R.zoom,$.updateProjectionMatrix(),R=null}i.dispatchEvent({type:"sessionend"})}this.setFramebufferScaleFactor=function($){s=$,i.isPresenting===!0&&Ft("WebXRManager: Cannot change framebuffer scale while presenting.")},this.setReferenceSpaceType=function($){a=$,i.isPresenting===!0&&Ft("WebXRManager: Cannot change reference space type while presenting.")},this.getReferenceSpace=function(){return l||o},this.setReferenceSpace=function($){l=$},this.getBaseLayer=function(){return f!==null?f:d},this.getBinding=function(){return h===null&&y&&(h=new XRWebGLBinding(r,n)),h},this.getFrame=function(){return p},this.getSession=function(){return r},this.setSession=async function($){if(r=$,r!==null){if(S=t.getRenderTarget(),r.addEventListener("select",k),r.addEventListener("selectstart",k),r.addEventListener("selectend",k),r.addEventListener("squeeze",k),r.addEventListener("squeezestart",k),r.addEventListener("squeezeend",k),r.addEventListener("end",F),r.addEventListener("inputsourceschange",Z),v.xrCompatible!==!0&&await n.makeXRCompatible(),M=t.getPixelRatio(),t.getSize(x),y&&"createProjectionLayer"in XRWebGLBinding.prototype){let ft=null,ot=null,rt=null;v.depth&&(rt=v.stencil?n.DEPTH24_STENCIL8:n.DEPTH_COMPONENT24,ft=v.stencil?Lr:Cr,ot=v.stencil?js:Ci);let J={colorFormat:n.RGBA8,depthFormat:rt,scaleFactor:s};h=this.getBinding(),f=h.createProjectionLayer(J),r.updateRenderState({layers:[f]}),t.setPixelRatio(1),t.setSize(f.textureWidth,f.textureHeight,!1),_=new qn(f.textureWidth,f.textureHeight,{format:Pi,type:On,depthTexture:new Ir(f.textureWidth,f.textureHeight,ot,void 0,void 0,void 0,void 0,void 0,void 0,ft),stencilBuffer:v.stencil,colorSpace:t.outputColorSpace,samples:v.antialias?4:0,resolveDepthBuffer:f.ignoreDepthValues===!1,resolveStencilBuffer:f.ignoreDepthValues===!1,storeMultisampledDepthBuffer:f.ignoreDepthValues===!1,storeMultisampledStencilBuffer:f.ignoreDepthValues===!1})}else{let ft={antialias:v.antialias,alpha:!0,depth:v.depth,stencil:v.stencil,framebufferScaleFactor:s};d=new XRWebGLLayer(r,n,ft),r.updateRenderState({baseLayer:d}),t.setPixelRatio(1),t.setSize(d.framebufferWidth,d.framebufferHeight,!1),_=new qn(d.framebufferWidth,d.framebufferHeight,{format:Pi,type:On,colorSpace:t.outputColorSpace,stencilBuffer:v.stencil,resolveDepthBuffer:d.ignoreDepthValues===!1,resolveStencilBuffer:d.ignoreDepthValues===!1,storeMultisampledDepthBuffer:d.ignoreDepthValues===!1,storeMultisampledStencilBuffer:d.ignoreDepthValues===!1})}_.isXRRenderTarget=!0,this.setFoveation(c),l=null,o=await r.requestReferenceSpace(a),ct.setContext(r),ct.start(),i.isPresenting=!0,i.dispatchEvent({type:"sessionstart"})}},this.getEnvironmentBlendMode=function(){if(r!==null)return r.environmentBlendMode},this.getDepthTexture=function(){return m.getDepthTexture()};function Z($){for(let at=0;at<$.removed.length;at++){let ft=$.removed[at],ot=b.indexOf(ft);ot>=0&&(b[ot]=null,w[ot].disconnect(ft))}for(let at=0;at<$.added.length;at++){let ft=$.added[at],ot=b.indexOf(ft);if(ot===-1){for(let J=0;J<w.length;J++)if(J>=b.length){b.push(ft),ot=J;break}else if(b[J]===null){b[J]=ft,ot=J;break}if(ot===-1)break}let rt=w[ot];rt&&rt.connect(ft)}}function U($,at){at===null?$.matrixWorld.copy($.matrix):$.matrixWorld.multiplyMatrices(at.matrixWorld,$.matrix),$.matrixWorldInverse.copy($.matrixWorld).invert()}this.updateCamera=function($){if(r===null)return;let at=$.near,ft=$.far;m.texture!==null&&(m.depthNear>0&&(at=m.depthNear),m.depthFar>0&&(ft=m.depthFar)),B.near=C.near=E.near=at,B.far=C.far=E.far=ft,(I!==B.near||L!==B.far)&&(r.updateRenderState({depthNear:B.near,depthFar:B.far}),I=B.near,L=B.far),B.layers.mask=$.layers.mask|6,E.layers.mask=B.layers.mask&-5,C.layers.mask=B.layers.mask&-3;let ot=$.parent,rt=B.cameras;U(B,ot);for(let J=0;J<rt.length;J++)U(rt[J],ot);B.projectionMatrix.copy(E.projectionMatrix),B.projectionMatrixInverse.copy(E.projectionMatrixInverse),R===null&&$.isPerspectiveCamera&&(R={camera:$,fov:$.fov,zoom:$.zoom}),G($,B,ot)};function G($,at,ft){ft===null?$.matrix.copy(at.matrixWorld):($.matrix.copy(ft.matrixWorld),$.matrix.invert(),$.matrix.multiply(at.matrixWorld)),$.matrix.decompose($.position,$.quaternion,$.scale),$.updateMatrixWorld(!0),$.projectionMatrix.copy(at.projectionMatrix),$.projectionMatrixInverse.copy(at.projectionMatrixInverse),$.isPerspectiveCamera&&($.fov=Jo*2*Math.atan(1/$.projectionMatrix.elements[5]),$.zoom=1)}this.getCamera=function(){return B},this.getFoveation=function(){if(!(f===null&&d===null))return c},this.setFoveation=function($){c=$,f!==null&&(f.fixedFoveation=$),d!==null&&d.fixedFoveation!==void 0&&(d.fixedFoveation=$)},this.hasDepthSensing=function(){return m.texture!==null},this.getDepthSensingMesh=function(){return m.getMesh(B)},this.getCameraTexture=function($){return g[$]};let q=null;function st($,at){if(u=at.getViewerPose(l||o),p=at,u!==null){let ft=u.views;d!==null&&(t.setRenderTargetFramebuffer(_,d.framebuffer),t.setRenderTarget(_));let ot=!1;ft.length!==B.cameras.length&&(B.cameras.length=0,ot=!0);for(let lt=0;lt<ft.length;lt++){let K=ft[lt],It=null;if(d!==null)It=d.getViewport(K);else{let Ut=h.getViewSubImage(f,K);It=Ut.viewport,lt===0&&(t.setRenderTargetTextures(_,Ut.colorTexture,Ut.depthStencilTexture),t.setRenderTarget(_))}let pt=N[lt];pt===void 0&&(pt=new vn,pt.layers.enable(lt),pt.viewport=new Te,N[lt]=pt),pt.matrix.fromArray(K.transform.matrix),pt.matrix.decompose(pt.position,pt.quaternion,pt.scale),pt.projectionMatrix.fromArray(K.projectionMatrix),pt.projectionMatrixInverse.copy(pt.projectionMatrix).invert(),pt.viewport.set(It.x,It.y,It.width,It.height),lt===0&&(B.matrix.copy(pt.matrix),B.matrix.decompose(B.position,B.quaternion,B.scale)),ot===!0&&B.cameras.push(pt)}let rt=r.enabledFeatures;if(rt&&rt.includes("depth-sensing")&&r.depthUsage=="gpu-optimized"&&y){h=i.getBinding();let lt=h.getDepthInformation(ft[0]);lt&&lt.isValid&&lt.texture&&m.init(lt,r.renderState)}if(rt&&rt.includes("camera-access")&&y){t.state.unbindTexture(),h=i.getBinding();for(let lt=0;lt<ft.length;lt++){let K=ft[lt].camera;if(K){let It=g[K];It||(It=new Ic,g[K]=It);let pt=h.getCameraImage(K);It.sourceTexture=pt}}}}for(let ft=0;ft<w.length;ft++){let ot=b[ft],rt=w[ft];ot!==null&&rt!==void 0&&rt.update(ot,at,l||o)}q&&q($,at),at.detectedPlanes&&i.dispatchEvent({type:"planesdetected",data:at}),p=null}let ct=new Nb;ct.setAnimationLoop(st),this.setAnimationLoop=function($){q=$},this.dispose=function(){}}},lN=new we,Hb=new zt;Hb.set(-1,0,0,0,1,0,0,0,1);function uN(e,t){function n(m,g){m.matrixAutoUpdate===!0&&m.updateMatrix(),g.value.copy(m.matrix)}function i(m,g){g.color.getRGB(m.fogColor.value,Am(e)),g.isFog?(m.fogNear.value=g.near,m.fogFar.value=g.far):g.isFogExp2&&(m.fogDensity.value=g.density)}function r(m,g,v,S,_){g.isNodeMaterial?g.uniformsNeedUpdate=!1:g.isMeshBasicMaterial?s(m,g):g.isMeshLambertMaterial?(s(m,g),g.envMap&&(m.envMapIntensity.value=g.envMapIntensity)):g.isMeshToonMaterial?(s(m,g),h(m,g)):g.isMeshPhongMaterial?(s(m,g),u(m,g),g.envMap&&(m.envMapIntensity.value=g.envMapIntensity)):g.isMeshStandardMaterial?(s(m,g),f(m,g),g.isMeshPhysicalMaterial&&d(m,g,_)):g.isMeshMatcapMaterial?(s(m,g),p(m,g)):g.isMeshDepthMaterial?s(m,g):g.isMeshDistanceMaterial?(s(m,g),y(m,g)):g.isMeshNormalMaterial?s(m,g):g.isLineBasicMaterial?(o(m,g),g.isLineDashedMaterial&&a(m,g)):g.isPointsMaterial?c(m,g,v,S):g.isSpriteMaterial?l(m,g):g.isShadowMaterial?(m.color.value.copy(g.color),m.opacity.value=g.opacity):g.isShaderMaterial&&(g.uniformsNeedUpdate=!1)}function s(m,g){m.opacity.value=g.opacity,g.color&&m.diffuse.value.copy(g.color),g.emissive&&m.emissive.value.copy(g.emissive).multiplyScalar(g.emissiveIntensity),g.map&&(m.map.value=g.map,n(g.map,m.mapTransform)),g.alphaMap&&(m.alphaMap.value=g.alphaMap,n(g.alphaMap,m.alphaMapTransform)),g.bumpMap&&(m.bumpMap.value=g.bumpMap,n(g.bumpMap,m.bumpMapTransform),m.bumpScale.value=g.bumpScale,g.side===Tn&&(m.bumpScale.value*=-1)),g.normalMap&&(m.normalMap.value=g.normalMap,n(g.normalMap,m.normalMapTransform),m.normalScale.value.copy(g.normalScale),g.side===Tn&&m.normalScale.value.negate()),g.displacementMap&&(m.displacementMap.value=g.displacementMap,n(g.displacementMap,m.displacementMapTransform),m.displacementScale.value=g.displacementScale,m.displacementBias.value=g.displacementBias),g.emissiveMap&&(m.emissiveMap.value=g.emissiveMap,n(g.emissiveMap,m.emissiveMapTransform)),g.specularMap&&(m.specularMap.value=g.specularMap,n(g.specularMap,m.specularMapTransform)),g.alphaTest>0&&(m.alphaTest.value=g.alphaTest);let v=t.get(g),S=v.envMap,_=v.envMapRotation;S&&(m.envMap.value=S,m.envMapRotation.value.setFromMatrix4(lN.makeRotationFromEuler(_)).transpose(),S.isCubeTexture&&S.isRenderTargetTexture===!1&&m.envMapRotation.value.premultiply(Hb),m.reflectivity.value=g.reflectivity,m.ior.value=g.ior,m.refractionRatio.value=g.refractionRatio),g.lightMap&&(m.lightMap.value=g.lightMap,m.lightMapIntensity.value=g.lightMapIntensity,n(g.lightMap,m.lightMapTransform)),g.aoMap&&(m.aoMap.value=g.aoMap,m.aoMapIntensity.value=g.aoMapIntensity,n(g.aoMap,m.aoMapTransform))}function o(m,g){m.diffuse.value.copy(g.color),m.opacity.value=g.opacity,g.map&&(m.map.value=g.map,n(g.map,m.mapTransform))}function a(m,g){m.dashSize.value=g.dashSize,m.totalSize.value=g.dashSize+g.gapSize,m.scale.value=g.scale}function c(m,g,v,S){m.diffuse.value.copy(g.color),m.opacity.value=g.opacity,m.size.value=g.size*v,m.scale.value=S*.5,g.map&&(m.map.value=g.map,n(g.map,m.uvTransform)),g.alphaMap&&(m.alphaMap.value=g.alphaMap,n(g.alphaMap,m.alphaMapTransform)),g.alphaTest>0&&(m.alphaTest.value=g.alphaTest)}function l(m,g){m.diffuse.value.copy(g.color),m.opacity.value=g.opacity,m.rotation.value=g.rotation,g.map&&(m.map.value=g.map,n(g.map,m.mapTransform)),g.alphaMap&&(m.alphaMap.value=g.alphaMap,n(g.alphaMap,m.alphaMapTransform)),g.alphaTest>0&&(m.alphaTest.value=g.alphaTest)}function u(m,g){m.specular.value.copy(g.specular),m.shininess.value=Math.max(g.shininess,1e-4)}function h(m,g){g.gradientMap&&(m.gradientMap.value=g.gradientMap)}function f(m,g){m.metalness.value=g.metalness,g.metalnessMap&&(m.metalnessMap.value=g.metalnessMap,n(g.metalnessMap,m.metalnessMapTransform)),m.roughness.value=g.roughness,g.roughnessMap&&(m.roughnessMap.value=g.roughnessMap,n(g.roughnessMap,m.roughnessMapTransform)),g.envMap&&(m.envMapIntensity.value=g.envMapIntensity)}function d(m,g,v){m.ior.value=g.ior,g.diffuseRoughness>0&&(m.diffuseRoughness.value=g.diffuseRoughness,g.diffuseRoughnessMap&&(m.diffuseRoughnessMap.value=g.diffuseRoughnessMap,n(g.diffuseRoughnessMap,m.diffuseRoughnessMapTransform))),g.sheen>0&&(m.sheenColor.value.copy(g.sheenColor).multiplyScalar(g.sheen),m.sheenRoughness.value=g.sheenRoughness,g.sheenColorMap&&(m.sheenColorMap.value=g.sheenColorMap,n(g.sheenColorMap,m.sheenColorMapTransform)),g.sheenRoughnessMap&&(m.sheenRoughnessMap.value=g.sheenRoughnessMap,n(g.sheenRoughnessMap,m.sheenRoughnessMapTransform))),g.clearcoat>0&&(m.clearcoat.value=g.clearcoat,m.clearcoatRoughness.value=g.clearcoatRoughness,g.clearcoatMap&&(m.clearcoatMap.value=g.clearcoatMap,n(g.clearcoatMap,m.clearcoatMapTransform)),g.clearcoatRoughnessMap&&(m.clearcoatRoughnessMap.value=g.clearcoatRoughnessMap,n(g.clearcoatRoughnessMap,m.clearcoatRoughnessMapTransform)),g.clearcoatNormalMap&&(m.clearcoatNormalMap.value=g.clearcoatNormalMap,n(g.clearcoatNormalMap,m.clearcoatNormalMapTransform),m.clearcoatNormalScale.value.copy(g.clearcoatNormalScale),g.side===Tn&&m.clearcoatNormalScale.value.negate())),g.dispersion>0&&(m.dispersion.value=g.dispersion),g.retroreflectivity>0&&(m.retroreflectivity.value=g.retroreflectivity),g.iridescence>0&&(m.iridescence.value=g.iridescence,m.iridescenceIOR.value=g.iridescenceIOR,m.iridescenceThicknessMinimum.value=g.iridescenceThicknessMinimum,m.iridescenceThicknessMaximum.value=g.iridescenceThicknessMaximum,g.iridescenceMap&&(m.iridescenceMap.value=g.iridescenceMap,n(g.iridescenceMap,m.iridescenceMapTransform)),g.iridescenceThicknessMap&&(m.iridescenceThicknessMap.value=g.iridescenceThicknessMap,n(g.iridescenceThicknessMap,m.iridescenceThicknessMapTransform))),g.transmission>0&&(m.transmission.value=g.transmission,m.transmissionSamplerMap.value=v.texture,m.transmissionSamplerSize.value.set(v.width,v.height),g.transmissionMap&&(m.transmissionMap.value=g.transmissionMap,n(g.transmissionMap,m.transmissionMapTransform)),m.thickness.value=g.thickness,g.thicknessMap&&(m.thicknessMap.value=g.thicknessMap,n(g.thicknessMap,m.thicknessMapTransform)),m.attenuationDistance.value=g.attenuationDistance,m.attenuationColor.value.copy(g.attenuationColor)),g.anisotropy>0&&(m.anisotropyVector.value.set(g.anisotropy*Math.cos(g.anisotropyRotation),g.anisotropy*Math.sin(g.anisotropyRotation)),g.anisotropyMap&&(m.anisotropyMap.value=g.anisotropyMap,n(g.anisotropyMap,m.anisotropyMapTransform))),m.specularIntensity.value=g.specularIntensity,m.specularColor.value.copy(g.specularColor),g.specularColorMap&&(m.specularColorMap.value=g.specularColorMap,n(g.specularColorMap,m.specularColorMapTransform)),g.specularIntensityMap&&(m.specularIntensityMap.value=g.specularIntensityMap,n(g.specularIntensityMap,m.specularIntensityMapTransform))}function p(m,g){g.matcap&&(m.matcap.value=g.matcap)}function y(m,g){let v=t.get(g).light;m.referencePosition.value.setFromMatrixPosition(v.matrixWorld),m.nearDistance.value=v.shadow.camera.near,m.farDistance.value=v.shadow.camera.far}return{refreshFogUniforms:i,refreshMaterialUniforms:r}}function fN(e,t,n,i){let r={},s={};function o(v,S){let _=S.program;i.uniformBlockBinding(v,_,r[v.id])}function a(v,S){let _=r[v.id];_===void 0&&(p(v),_=c(v),r[v.id]=_,v.addEventListener("dispose",m));let w=S.program;i.updateUBOMapping(v,w);let b=t.render.frame;s[v.id]!==b&&(l(v),s[v.id]=b)}function c(v){let S=e.createBuffer(),_=v.__size,w=v.usage;return e.bindBuffer(e.UNIFORM_BUFFER,S),e.bufferData(e.UNIFORM_BUFFER,_,w),e.bindBuffer(e.UNIFORM_BUFFER,null),S}function l(v){let S=r[v.id],_=v.uniforms,w=v.__cache;e.bindBuffer(e.UNIFORM_BUFFER,S);for(let b=0,x=_.length;b<x;b++){let M=_[b];if(Array.isArray(M))for(let R=0,E=M.length;R<E;R++)u(M[R],b,R,w);else u(M,b,0,w)}e.bindBuffer(e.UNIFORM_BUFFER,null)}function u(v,S,_,w){if(f(v,S,_,w)===!0){let b=v.__offset,x=v.value;if(Array.isArray(x)){let M=0;for(let R=0;R<x.length;R++){let E=x[R],C=y(E,!0);h(E,v.__data,M),M+=C.storage/Float32Array.BYTES_PER_ELEMENT}}else h(x,v.__data,0);e.bufferSubData(e.UNIFORM_BUFFER,b,v.__data)}}function h(v,S,_){typeof v=="number"||typeof v=="boolean"?S[_]=v:v.isMatrix3?(S[_]=v.elements[0],S[_+1]=v.elements[1],S[_+2]=v.elements[2],S[_+3]=0,S[_+4]=v.elements[3],S[_+5]=v.elements[4],S[_+6]=v.elements[5],S[_+7]=0,S[_+8]=v.elements[6],S[_+9]=v.elements[7],S[_+10]=v.elements[8],S[_+11]=0):ArrayBuffer.isView(v)?S.set(v.subarray(0,S.length-_),_):v.toArray(S,_)}function f(v,S,_,w){let b=v.value,x=S+"_"+_;if(Array.isArray(b)){w[x]===void 0&&(w[x]=[]);let M=w[x],R=!1;for(let E=0;E<b.length;E++)d(b[E],M,E)===!0&&(R=!0);return R}return d(b,w,x)}function d(v,S,_){if(S[_]===void 0)return typeof v=="number"||typeof v=="boolean"?S[_]=v:ArrayBuffer.isView(v)?S[_]=v.slice():S[_]=v.clone(),!0;{let w=S[_];if(typeof v=="number"||typeof v=="boolean"){if(w!==v)return S[_]=v,!0}else{if(ArrayBuffer.isView(v))return!0;if(w.equals(v)===!1)return w.copy(v),!0}}return!1}function p(v){let S=v.uniforms,_=0,w=16;for(let x=0,M=S.length;x<M;x++){let R=Array.isArray(S[x])?S[x]:[S[x]];for(let E=0,C=R.length;E<C;E++){let N=R[E],B=Array.isArray(N.value)?N.value:[N.value],I=Array.isArray(S[x])||Array.isArray(N.value),L=_;for(let F=0,Z=B.length;F<Z;F++){let U=B[F],G=y(U,I),q=_%w,st=q%G.boundary,ct=q+st;_+=st,ct!==0&&w-ct<G.storage&&(_+=w-ct),F===0&&(L=_),_+=G.storage}let k=N.type==="int"?Int32Array:N.type==="uint"?Uint32Array:Float32Array;N.__data=new k((_-L)/Float32Array.BYTES_PER_ELEMENT),N.__offset=L}}let b=_%w;return b>0&&(_+=w-b),v.__size=_,v.__cache={},this}function y(v,S){let _={boundary:0,storage:0};return typeof v=="number"||typeof v=="boolean"?(_.boundary=4,_.storage=4):v.isVector2?(_.boundary=8,_.storage=8):v.isVector3||v.isColor?(_.boundary=16,_.storage=12):v.isVector4?(_.boundary=16,_.storage=16):v.isMatrix3?(_.boundary=16,_.storage=48):v.isMatrix4?(_.boundary=16,_.storage=64):v.isTexture?Ft("WebGLRenderer: Texture samplers can not be part of an uniforms group."):ArrayBuffer.isView(v)?(_.boundary=16,_.storage=v.byteLength):Ft("WebGLRenderer: Unsupported uniform value type.",v),S===!0&&(_.boundary=16,_.storage=Math.ceil(_.storage/16)*16),_}function m(v){let S=v.target;S.removeEventListener("dispose",m),e.deleteBuffer(r[S.id]),delete r[S.id],delete s[S.id]}function g(){for(let v in r)e.deleteBuffer(r[v]);r={},s={}}return{bind:o,update:a,dispose:g}}var hN=new Uint16Array([12469,15057,12620,14925,13266,14620,13807,14376,14323,13990,14545,13625,14713,13328,14840,12882,14931,12528,14996,12233,15039,11829,15066,11525,15080,11295,15085,10976,15082,10705,15073,10495,13880,14564,13898,14542,13977,14430,14158,14124,14393,13732,14556,13410,14702,12996,14814,12596,14891,12291,14937,11834,14957,11489,14958,11194,14943,10803,14921,10506,14893,10278,14858,9960,14484,14039,14487,14025,14499,13941,14524,13740,14574,13468,14654,13106,14743,12678,14818,12344,14867,11893,14889,11509,14893,11180,14881,10751,14852,10428,14812,10128,14765,9754,14712,9466,14764,13480,14764,13475,14766,13440,14766,13347,14769,13070,14786,12713,14816,12387,14844,11957,14860,11549,14868,11215,14855,10751,14825,10403,14782,10044,14729,9651,14666,9352,14599,9029,14967,12835,14966,12831,14963,12804,14954,12723,14936,12564,14917,12347,14900,11958,14886,11569,14878,11247,14859,10765,14828,10401,14784,10011,14727,9600,14660,9289,14586,8893,14508,8533,15111,12234,15110,12234,15104,12216,15092,12156,15067,12010,15028,11776,14981,11500,14942,11205,14902,10752,14861,10393,14812,9991,14752,9570,14682,9252,14603,8808,14519,8445,14431,8145,15209,11449,15208,11451,15202,11451,15190,11438,15163,11384,15117,11274,15055,10979,14994,10648,14932,10343,14871,9936,14803,9532,14729,9218,14645,8742,14556,8381,14461,8020,14365,7603,15273,10603,15272,10607,15267,10619,15256,10631,15231,10614,15182,10535,15118,10389,15042,10167,14963,9787,14883,9447,14800,9115,14710,8665,14615,8318,14514,7911,14411,7507,14279,7198,15314,9675,15313,9683,15309,9712,15298,9759,15277,9797,15229,9773,15166,9668,15084,9487,14995,9274,14898,8910,14800,8539,14697,8234,14590,7790,14479,7409,14367,7067,14178,6621,15337,8619,15337,8631,15333,8677,15325,8769,15305,8871,15264,8940,15202,8909,15119,8775,15022,8565,14916,8328,14804,8009,14688,7614,14569,7287,14448,6888,14321,6483,14088,6171,15350,7402,15350,7419,15347,7480,15340,7613,15322,7804,15287,7973,15229,8057,15148,8012,15046,7846,14933,7611,14810,7357,14682,7069,14552,6656,14421,6316,14251,5948,14007,5528,15356,5942,15356,5977,15353,6119,15348,6294,15332,6551,15302,6824,15249,7044,15171,7122,15070,7050,14949,6861,14818,6611,14679,6349,14538,6067,14398,5651,14189,5311,13935,4958,15359,4123,15359,4153,15356,4296,15353,4646,15338,5160,15311,5508,15263,5829,15188,6042,15088,6094,14966,6001,14826,5796,14678,5543,14527,5287,14377,4985,14133,4586,13869,4257,15360,1563,15360,1642,15358,2076,15354,2636,15341,3350,15317,4019,15273,4429,15203,4732,15105,4911,14981,4932,14836,4818,14679,4621,14517,4386,14359,4156,14083,3795,13808,3437,15360,122,15360,137,15358,285,15355,636,15344,1274,15322,2177,15281,2765,15215,3223,15120,3451,14995,3569,14846,3567,14681,3466,14511,3305,14344,3121,14037,2800,13753,2467,15360,0,15360,1,15359,21,15355,89,15346,253,15325,479,15287,796,15225,1148,15133,1492,15008,1749,14856,1882,14685,1886,14506,1783,14324,1608,13996,1398,13702,1183]),Zi=null;function dN(){return Zi===null&&(Zi=new Yu(hN,16,16,xs,Ii),Zi.name="DFG_LUT",Zi.minFilter=Mn,Zi.magFilter=Mn,Zi.wrapS=$i,Zi.wrapT=$i,Zi.generateMipmaps=!1,Zi.needsUpdate=!0),Zi}var nh=class{constructor(t={}){let{canvas:n=nb(),context:i=null,depth:r=!0,stencil:s=!1,alpha:o=!1,antialias:a=!1,premultipliedAlpha:c=!0,preserveDrawingBuffer:l=!1,powerPreference:u="default",failIfMajorPerformanceCaveat:h=!1,reversedDepthBuffer:f=!1,outputBufferType:d=On}=t;this.isWebGLRenderer=!0;let p;if(i!==null){if(typeof WebGLRenderingContext<"u"&&i instanceof WebGLRenderingContext)throw new Error("THREE.WebGLRenderer: WebGL 1 is not supported since r163.");p=i.getContextAttributes().alpha}else p=o;let y=d,m=new Set([bf,vf,_f]),g=new Set([On,Ci,sa,js,yf,xf]),v=new Uint32Array(4),S=new Int32Array(4),_={textures:[],min:[],max:[],resolution:[]},w=null,b=null,x=[],M=[],R=null;this.domElement=n,this.debug={checkShaderErrors:!0,diagnostics:{keywords:!1},onShaderError:null},this.autoClear=!0,this.autoClearColor=!0,this.autoClearDepth=!0,this.autoClearStencil=!0,this.sortObjects=!0,this.clippingPlanes=[],this.localClippingEnabled=!1,this.toneMapping=Yi,this.toneMappingExposure=1,this.transmissionResolutionScale=1;let E=this,C=!1,N=null,B=null,I=null,L=null;this._outputColorSpace=Xn;let k=0,F=0,Z=null,U=-1,G=null,q=new Te,st=new Te,ct=null,$=new Zt(0),at=0,ft=n.width,ot=n.height,rt=1,J=null,gt=null,lt=new Te(0,0,ft,ot),K=new Te(0,0,ft,ot),It=!1,pt=new hs,Ut=new Zu,Gt=!1,ce=!1,oe=new we,Xe=new W,Be=new Te,Ln={background:null,fog:null,environment:null,overrideMaterial:null,isScene:!0},xn=!1;function Nn(){return Z===null?rt:1}let z=i;function Dn(A,O){return n.getContext(A,O)}let _e,ve,mt,Ce,Lt,Bt,P,T,V,ut,nt,yt,Mt,Q,tt,_t,D,et,j,vt,dt,xt,Nt;try{let A={alpha:!0,depth:r,stencil:s,antialias:a,premultipliedAlpha:c,preserveDrawingBuffer:l,powerPreference:u,failIfMajorPerformanceCaveat:h};if("setAttribute"in n&&n.setAttribute("data-engine",`three.js r${"187"}`),n.addEventListener("webglcontextlost",Dt,!1),n.addEventListener("webglcontextrestored",qt,!1),n.addEventListener("webglcontextcreationerror",wt,!1),z===null){let O="webgl2";if(z=Dn(O,A),z===null)throw Dn(O)?new Error("THREE.WebGLRenderer: Error creating WebGL context with your selected attributes."):new Error("THREE.WebGLRenderer: Error creating WebGL context.")}Yt()}catch(A){throw n.removeEventListener("webglcontextlost",Dt,!1),n.removeEventListener("webglcontextrestored",qt,!1),n.removeEventListener("webglcontextcreationerror",wt,!1),kt("WebGLRenderer: "+A.message),A}function Yt(){_e=new wP(z),_e.init(),dt=new oN(z,_e),ve=new dP(z,_e,t,dt),mt=new rN(z,_e),ve.reversedDepthBuffer&&f&&mt.buffers.depth.setReversed(!0),B=z.createFramebuffer(),I=z.createFramebuffer(),L=z.createFramebuffer(),Ce=new EP(z),Lt=new WL,Bt=new sN(z,_e,mt,Lt,ve,dt,Ce),P=new SP(E),T=new RC(z),xt=new fP(z,T),V=new TP(z,T,Ce,xt),ut=new RP(z,V,T,xt,Ce),et=new CP(z,ve,Bt),tt=new pP(Lt),nt=new HL(E,P,_e,ve,xt,tt),yt=new uN(E,Lt),Mt=new XL,Q=new jL(_e),D=new uP(E,P,mt,ut,p,c),_t=new iN(E,ut,ve),Nt=new fN(z,Ce,ve,mt),j=new hP(z,_e,Ce),vt=new AP(z,_e,Ce),Ce.programs=nt.programs,E.capabilities=ve,E.extensions=_e,E.properties=Lt,E.renderLists=Mt,E.shadowMap=_t,E.state=mt,E.info=Ce}y!==On&&(R=new PP(y,n.width,n.height,a,r,s));let ht=new km(E,z);this.xr=ht,this.getContext=function(){return z},this.getContextAttributes=function(){return z.getContextAttributes()},this.forceContextLoss=function(){let A=_e.get("WEBGL_lose_context");A&&A.loseContext()},this.forceContextRestore=function(){let A=_e.get("WEBGL_lose_context");A&&A.restoreContext()},this.getPixelRatio=function(){return rt},this.setPixelRatio=function(A){A!==void 0&&(rt=A,this.setSize(ft,ot,!1))},this.getSize=function(A){return A.set(ft,ot)},this.setSize=function(A,O,Y=!0){if(ht.isPresenting){Ft("WebGLRenderer: Can't change size while VR device is presenting.");return}ft=A,ot=O,n.width=Math.floor(A*rt),n.height=Math.floor(O*rt),Y===!0&&(n.style.width=A+"px",n.style.height=O+"px"),R!==null&&R.setSize(n.width,n.height),this.setViewport(0,0,A,O)},this.getDrawingBufferSize=function(A){return A.set(ft*rt,ot*rt).floor()},this.setDrawingBufferSize=function(A,O,Y){ft=A,ot=O,rt=Y,n.width=Math.floor(A*Y),n.height=Math.floor(O*Y),this.setViewport(0,0,A,O)},this.setEffects=function(A){if(y===On){kt("WebGLRenderer: setEffects() requires outputBufferType set to HalfFloatType or FloatType.");return}if(A){for(let O=0;O<A.length;O++)if(A[O].isOutputPass===!0){Ft("WebGLRenderer: OutputPass is not needed in setEffects(). Tone mapping and color space conversion are applied automatically.");break}}R.setEffects(A||[])},this.getCurrentViewport=function(A){return A.copy(q)},this.getViewport=function(A){return A.copy(lt)},this.setViewport=function(A,O,Y,H){A.isVector4?lt.set(A.x,A.y,A.z,A.w):lt.set(A,O,Y,H),mt.viewport(q.copy(lt).multiplyScalar(Nn()).round())},this.getScissor=function(A){return A.copy(K)},this.setScissor=function(A,O,Y,H){A.isVector4?K.set(A.x,A.y,A.z,A.w):K.set(A,O,Y,H),mt.scissor(st.copy(K).multiplyScalar(Nn()).round())},this.getScissorTest=function(){return It},this.setScissorTest=function(A){mt.setScissorTest(It=A)},this.setOpaqueSort=function(A){J=A},this.setTransparentSort=function(A){gt=A},this.getClearColor=function(A){return A.copy(D.getClearColor())},this.setClearColor=function(){D.setClearColor(...arguments)},this.getClearAlpha=function(){return D.getClearAlpha()},this.setClearAlpha=function(){D.setClearAlpha(...arguments)},this.clear=function(A=!0,O=!0,Y=!0){let H=0;if(A){let X=!1;if(Z!==null){let St=Z.texture.format;X=m.has(St)}if(X){let St=Z.texture.type,Et=g.has(St),bt=D.getClearColor(),At=D.getClearAlpha(),Pt=bt.r,Vt=bt.g,Qt=bt.b;Et?(v[0]=Pt,v[1]=Vt,v[2]=Qt,v[3]=At,z.clearBufferuiv(z.COLOR,0,v)):(S[0]=Pt,S[1]=Vt,S[2]=Qt,S[3]=At,z.clearBufferiv(z.COLOR,0,S))}else H|=z.COLOR_BUFFER_BIT}O&&(H|=z.DEPTH_BUFFER_BIT,this.state.buffers.depth.setMask(!0)),Y&&(H|=z.STENCIL_BUFFER_BIT,this.state.buffers.stencil.setMask(4294967295)),H!==0&&z.clear(H)},this.clearColor=function(){this.clear(!0,!1,!1)},this.clearDepth=function(){this.clear(!1,!0,!1)},this.clearStencil=function(){this.clear(!1,!1,!0)},this.setNodesHandler=function(A){A.setRenderer(this),N=A},this.dispose=function(){n.removeEventListener("webglcontextlost",Dt,!1),n.removeEventListener("webglcontextrestored",qt,!1),n.removeEventListener("webglcontextcreationerror",wt,!1),D.dispose(),Mt.dispose(),Q.dispose(),Bt.dispose(),Lt.dispose(),P.dispose(),ut.dispose(),V.dispose(),xt.dispose(),Nt.dispose(),nt.dispose(),ht.dispose(),ht.removeEventListener("sessionstart",D_),ht.removeEventListener("sessionend",F_),Gs.stop()};function Dt(A){A.preventDefault(),bm("WebGLRenderer: Context Lost."),C=!0}function qt(){bm("WebGLRenderer: Context Restored."),C=!1;let A=Ce.autoReset,O=_t.enabled,Y=_t.autoUpdate,H=_t.needsUpdate,X=_t.type;Yt(),Ce.autoReset=A,_t.enabled=O,_t.autoUpdate=Y,_t.needsUpdate=H,_t.type=X}function wt(A){kt("WebGLRenderer: A WebGL context could not be created. Reason: ",A.statusMessage)}function he(A){let O=A.target;O.removeEventListener("dispose",he),qe(O)}function qe(A){is(A),Lt.remove(A)}function is(A){let O=Lt.get(A).programs;O!==void 0&&(O.forEach(function(Y){nt.releaseProgram(Y)}),A.isShaderMaterial&&nt.releaseShaderCache(A))}this.renderBufferDirect=function(A,O,Y,H,X,St){O===null&&(O=Ln);let Et=X.isMesh&&X.matrixWorld.determinantAffine()<0,bt=S3(A,O,Y,H,X);mt.setMaterial(H,Et);let At=Y.index,Pt=1;if(H.wireframe===!0){if(At=V.getWireframeAttribute(Y),At===void 0)return;Pt=2}let Vt=Y.drawRange,Qt=Y.attributes.position,Ct=Vt.start*Pt,te=(Vt.start+Vt.count)*Pt;St!==null&&(Ct=Math.max(Ct,St.start*Pt),te=Math.min(te,(St.start+St.count)*Pt)),At!==null?(Ct=Math.max(Ct,0),te=Math.min(te,At.count)):Qt!=null&&(Ct=Math.max(Ct,0),te=Math.min(te,Qt.count));let ke=te-Ct;if(ke<0||ke===1/0)return;xt.setup(X,H,bt,Y,At);let be,ye=j;if(At!==null&&(be=T.get(At),ye=vt,ye.setIndex(be)),X.isMesh)H.wireframe===!0?(mt.setLineWidth(H.wireframeLinewidth*Nn()),ye.setMode(z.LINES)):ye.setMode(z.TRIANGLES);else if(X.isLine){let fn=H.linewidth;fn===void 0&&(fn=1),mt.setLineWidth(fn*Nn()),X.isLineSegments?ye.setMode(z.LINES):X.isLineLoop?ye.setMode(z.LINE_LOOP):ye.setMode(z.LINE_STRIP)}else X.isPoints?ye.setMode(z.POINTS):X.isSprite&&ye.setMode(z.TRIANGLES);if(X.isBatchedMesh)if(_e.get("WEBGL_multi_draw"))ye.renderMultiDraw(X._multiDrawStarts,X._multiDrawCounts,X._multiDrawCount);else{let fn=X._multiDrawStarts,Rt=X._multiDrawCounts,_n=X._multiDrawCount,le=At?T.get(At).bytesPerElement:1,Vs=Lt.get(H).currentProgram.getUniforms();for(let hn=0;hn<_n;hn++)Vs.setValue(z,"_gl_DrawID",hn),ye.render(fn[hn]/le,Rt[hn])}else if(X.isInstancedMesh)ye.renderInstances(Ct,ke,X.count);else if(Y.isInstancedBufferGeometry){let fn=Y._maxInstanceCount!==void 0?Y._maxInstanceCount:1/0,Rt=Math.min(Y.instanceCount,fn);ye.renderInstances(Ct,ke,Rt)}else ye.render(Ct,ke)};function N_(A,O,Y,H){N!==null&&A.isNodeMaterial&&N.setObject(H,A),Gt===!0&&tt.setState(A,Y,!1),A.transparent===!0&&A.side===si&&A.forceSinglePass===!1?(A.side=Tn,A.needsUpdate=!0,fc(A,O,H),A.side=ys,A.needsUpdate=!0,fc(A,O,H),A.side=si):fc(A,O,H)}this.compile=function(A,O,Y=null){Y===null&&(Y=A),N!==null&&N.renderStart(A,O,Y),b=Q.get(Y),b.init(O),M.push(b),Y.traverseVisible(function(X){X.isLight&&X.layers.test(O.layers)&&(b.pushLight(X),X.castShadow&&b.pushShadow(X))}),A!==Y&&A.traverseVisible(function(X){X.isLight&&X.layers.test(O.layers)&&(b.pushLight(X),X.castShadow&&b.pushShadow(X))}),b.setupLights(),N!==null&&N.updateLights(b.state.lightsArray),ce=this.localClippingEnabled,Gt=tt.init(this.clippingPlanes,ce),Gt===!0&&tt.setGlobalState(this.clippingPlanes,O),N!==null&&_t.render(b.state.shadowsArray,Y,O);let H=new Set;return A.traverse(function(X){if(!(X.isMesh||X.isPoints||X.isLine||X.isSprite))return;let St=X.material;if(St)if(Array.isArray(St))for(let Et=0;Et<St.length;Et++){let bt=St[Et];N_(bt,Y,O,X),H.add(bt)}else N_(St,Y,O,X),H.add(St)}),b=M.pop(),N!==null&&N.renderEnd(),H},this.compileAsync=function(A,O,Y=null){let H=this.compile(A,O,Y);return new Promise(X=>{function St(){if(H.forEach(function(Et){let At=Lt.get(Et).currentProgram;(At===void 0||At.isReady())&&H.delete(Et)}),H.size===0){X(A);return}setTimeout(St,10)}_e.get("KHR_parallel_shader_compile")!==null?St():setTimeout(St,10)})};let xp=null;function b3(A){xp&&xp(A)}function D_(){Gs.stop()}function F_(){Gs.start()}let Gs=new Nb;Gs.setAnimationLoop(b3),typeof self<"u"&&Gs.setContext(self),this.setAnimationLoop=function(A){xp=A,ht.setAnimationLoop(A),A===null?Gs.stop():Gs.start()},ht.addEventListener("sessionstart",D_),ht.addEventListener("sessionend",F_),this.render=function(A,O){if(O!==void 0&&O.isCamera!==!0){kt("WebGLRenderer.render: camera is not an instance of THREE.Camera.");return}if(C===!0)return;N!==null&&N.renderStart(A,O);let Y=ht.enabled===!0&&ht.isPresenting===!0,H=R!==null&&(Z===null||Y)&&R.begin(E,Z);if(A.matrixWorldAutoUpdate===!0&&A.updateMatrixWorld(),O.parent===null&&O.matrixWorldAutoUpdate===!0&&O.updateMatrixWorld(),ht.enabled===!0&&ht.isPresenting===!0&&(R===null||R.isCompositing()===!1)&&(ht.cameraAutoUpdate===!0&&ht.updateCamera(O),O=ht.getCamera()),A.isScene===!0&&A.onBeforeRender(E,A,O,Z),b=Q.get(A,M.length),b.init(O),b.state.textureUnits=Bt.getTextureUnits(),M.push(b),oe.multiplyMatrices(O.projectionMatrix,O.matrixWorldInverse),O.isArrayCamera?Ut.setFromArrayCamera(O):pt.setFromProjectionMatrix(oe,ii,O.reversedDepth),ce=this.localClippingEnabled,Gt=tt.init(this.clippingPlanes,ce),w=Mt.get(A,x.length),w.init(),x.push(w),this.info.render.frame++,ht.enabled===!0&&ht.isPresenting===!0){let Et=E.xr.getDepthSensingMesh();Et!==null&&_p(Et,O,-1/0,E.sortObjects)}_p(A,O,0,E.sortObjects),w.finish(),N!==null&&N.updateLights(b.state.lightsArray),E.sortObjects===!0&&w.sort(J,gt),xn=ht.enabled===!1||ht.isPresenting===!1||ht.hasDepthSensing()===!1,xn&&D.addToRenderList(w,A),this.info.autoReset===!0&&this.info.reset(),Gt===!0&&tt.beginShadows();let X=b.state.shadowsArray;if(_t.render(X,A,O),Gt===!0&&tt.endShadows(),(H&&R.hasRenderPass())===!1){let Et=w.opaque,bt=w.transmissive;if(b.setupLights(),O.isArrayCamera){let At=O.cameras;if(bt.length>0)for(let Pt=0,Vt=At.length;Pt<Vt;Pt++){let Qt=At[Pt];O_(Et,bt,A,Qt)}xn&&D.render(A);for(let Pt=0,Vt=At.length;Pt<Vt;Pt++){let Qt=At[Pt];U_(w,A,Qt,Qt.viewport)}}else bt.length>0&&O_(Et,bt,A,O),xn&&D.render(A),U_(w,A,O)}Z!==null&&F===0&&(Bt.updateMultisampleRenderTarget(Z),Bt.updateRenderTargetMipmap(Z)),H&&R.end(E),A.isScene===!0&&A.onAfterRender(E,A,O),xt.resetDefaultState(),U=-1,G=null,M.pop(),M.length>0?(b=M[M.length-1],Bt.setTextureUnits(b.state.textureUnits),Gt===!0&&tt.setGlobalState(E.clippingPlanes,b.state.camera)):b=null,x.pop(),x.length>0?w=x[x.length-1]:w=null,N!==null&&N.renderEnd()};function _p(A,O,Y,H){if(A.visible===!1)return;if(A.layers.test(O.layers)){if(A.isGroup)Y=A.renderOrder;else if(A.isLOD)A.autoUpdate===!0&&A.update(O);else if(A.isLight)b.pushLight(A),A.castShadow&&b.pushShadow(A);else if(A.isSprite){let Et=O.isArrayCamera?Ut:pt;if(!A.frustumCulled||A.intersectsFrustum(Et)){H&&Be.setFromMatrixPosition(A.matrixWorld).applyMatrix4(oe);let bt=ut.update(A),At=A.material;At.visible&&w.push(A,bt,At,Y,Be.z,null,O)}}else if(A.isMesh||A.isLine||A.isPoints){let Et=O.isArrayCamera?Ut:pt;if(!A.frustumCulled||A.intersectsFrustum(Et)){let bt=ut.update(A),At=A.material;if(H&&(A.boundingSphere!==void 0?(A.boundingSphere===null&&A.computeBoundingSphere(),Be.copy(A.boundingSphere.center)):(bt.boundingSphere===null&&bt.computeBoundingSphere(),Be.copy(bt.boundingSphere.center)),Be.applyMatrix4(A.matrixWorld).applyMatrix4(oe)),Array.isArray(At)){let Pt=bt.groups;for(let Vt=0,Qt=Pt.length;Vt<Qt;Vt++){let Ct=Pt[Vt],te=At[Ct.materialIndex];te&&te.visible&&w.push(A,bt,te,Y,Be.z,Ct,O)}}else At.visible&&w.push(A,bt,At,Y,Be.z,null,O)}}}let St=A.children;for(let Et=0,bt=St.length;Et<bt;Et++)_p(St[Et],O,Y,H)}function U_(A,O,Y,H){let{opaque:X,transmissive:St,transparent:Et}=A;b.setupLightsView(Y),Gt===!0&&tt.setGlobalState(E.clippingPlanes,Y),H&&mt.viewport(q.copy(H)),X.length>0&&au(X,O,Y),St.length>0&&au(St,O,Y),Et.length>0&&au(Et,O,Y),mt.buffers.depth.setTest(!0),mt.buffers.depth.setMask(!0),mt.buffers.color.setMask(!0),mt.setPolygonOffset(!1)}function O_(A,O,Y,H){if((Y.isScene===!0?Y.overrideMaterial:null)!==null)return;if(b.state.transmissionRenderTarget[H.id]===void 0){let Ct=_e.has("EXT_color_buffer_half_float")||_e.has("EXT_color_buffer_float");b.state.transmissionRenderTarget[H.id]=new qn(1,1,{generateMipmaps:!0,type:Ct?Ii:On,minFilter:Pr,samples:Math.max(4,ve.samples),stencilBuffer:s,resolveDepthBuffer:!1,resolveStencilBuffer:!1,storeMultisampledDepthBuffer:!1,storeMultisampledStencilBuffer:!1,colorSpace:ee.workingColorSpace})}let St=b.state.transmissionRenderTarget[H.id],Et=H.viewport||q;St.setSize(Et.z*E.transmissionResolutionScale,Et.w*E.transmissionResolutionScale);let bt=E.getRenderTarget(),At=E.getActiveCubeFace(),Pt=E.getActiveMipmapLevel();E.setRenderTarget(St),E.getClearColor($),at=E.getClearAlpha(),at<1&&E.setClearColor(16777215,.5),E.clear(),xn&&D.render(Y);let Vt=E.toneMapping;E.toneMapping=Yi;let Qt=H.viewport;if(H.viewport!==void 0&&(H.viewport=void 0),b.setupLightsView(H),Gt===!0&&tt.setGlobalState(E.clippingPlanes,H),au(A,Y,H),Bt.updateMultisampleRenderTarget(St),Bt.updateRenderTargetMipmap(St),_e.has("WEBGL_multisampled_render_to_texture")===!1){let Ct=!1;for(let te=0,ke=O.length;te<ke;te++){let be=O[te],{object:ye,geometry:fn,material:Rt,group:_n}=be;if(Rt.side===si&&ye.layers.test(H.layers)){let le=Rt.side;Rt.side=Tn,Rt.needsUpdate=!0,B_(ye,Y,H,fn,Rt,_n),Rt.side=le,Rt.needsUpdate=!0,Ct=!0}}Ct===!0&&(Bt.updateMultisampleRenderTarget(St),Bt.updateRenderTargetMipmap(St))}E.setRenderTarget(bt,At,Pt),E.setClearColor($,at),Qt!==void 0&&(H.viewport=Qt),E.toneMapping=Vt}function au(A,O,Y){let H=O.isScene===!0?O.overrideMaterial:null;for(let X=0,St=A.length;X<St;X++){let Et=A[X],{object:bt,geometry:At,group:Pt}=Et,Vt=Et.material;Vt.allowOverride===!0&&H!==null&&(Vt=H),bt.layers.test(Y.layers)&&B_(bt,O,Y,At,Vt,Pt)}}function B_(A,O,Y,H,X,St){N!==null&&X.isNodeMaterial&&N.setObject(A,X),A.onBeforeRender(E,O,Y,H,X,St),A.modelViewMatrix.multiplyMatrices(Y.matrixWorldInverse,A.matrixWorld),A.normalMatrix.getNormalMatrix(A.modelViewMatrix),X.onBeforeRender(E,O,Y,H,A,St),X.transparent===!0&&X.side===si&&X.forceSinglePass===!1?(X.side=Tn,X.needsUpdate=!0,E.renderBufferDirect(Y,O,H,X,A,St),X.side=ys,X.needsUpdate=!0,E.renderBufferDirect(Y,O,H,X,A,St),X.side=si):E.renderBufferDirect(Y,O,H,X,A,St),A.onAfterRender(E,O,Y,H,X,St)}function k_(A){let O=0;for(let Y of A)Y.texture!==null&&O++;return O}function fc(A,O,Y){O.isScene!==!0&&(O=Ln);let H=Lt.get(A),X=b.state.lights,St=b.state.shadowsArray,Et=X.state.version,bt=nt.getParameters(A,X.state,St,O,Y,b.state.lightProbeGridArray),At=nt.getProgramCacheKey(bt),Pt=H.programs;H.environment=A.isMeshStandardMaterial||A.isMeshLambertMaterial||A.isMeshPhongMaterial?O.environment:null,H.fog=O.fog;let Vt=A.isMeshStandardMaterial||A.isMeshLambertMaterial&&!A.envMap||A.isMeshPhongMaterial&&!A.envMap;H.envMap=P.get(A.envMap||H.environment,Vt),H.envMapRotation=H.environment!==null&&A.envMap===null?O.environmentRotation:A.envMapRotation,Pt===void 0&&(A.addEventListener("dispose",he),Pt=new Map,H.programs=Pt,H.programVariants=new Map);let Qt=Pt.get(At);if(Qt!==void 0){if(H.currentProgram===Qt&&H.lightsStateVersion===Et)return G_(A,bt),Qt}else bt.uniforms=nt.getUniforms(A),N!==null&&A.isNodeMaterial&&N.build(A,Y,bt),A.onBeforeCompile(bt,E),Qt=nt.acquireProgram(bt,At),Pt.set(At,Qt),H.uniforms=bt.uniforms;let Ct=H.uniforms;return(!A.isShaderMaterial&&!A.isRawShaderMaterial||A.clipping===!0)&&(Ct.clippingPlanes=tt.uniform),G_(A,bt),H.needsLights=T3(A),H.lightsStateVersion=Et,H.needsLights&&(Ct.ambientLightColor.value=X.state.ambient,Ct.lightProbe.value=X.state.probe,Ct.sunLights.value=X.state.sun,Ct.sunLightShadows.value=X.state.sunShadow,Ct.directionalLights.value=X.state.directional,Ct.directionalLightShadows.value=X.state.directionalShadow,Ct.spotLights.value=X.state.spot,Ct.spotLightShadows.value=X.state.spotShadow,Ct.rectAreaLights.value=X.state.rectArea,Ct.ltc_1.value=X.state.rectAreaLTC1,Ct.ltc_2.value=X.state.rectAreaLTC2,Ct.pointLights.value=X.state.point,Ct.pointLightShadows.value=X.state.pointShadow,Ct.hemisphereLights.value=X.state.hemi,Ct.sunShadowMatrix.value=X.state.sunShadowMatrix,Ct.sunShadowCascade.value=X.state.sunShadowCascade,Ct.directionalShadowMatrix.value=X.state.directionalShadowMatrix,Ct.spotLightMatrix.value=X.state.spotLightMatrix,Ct.spotLightMap.value=X.state.spotLightMap,Ct.pointShadowMatrix.value=X.state.pointShadowMatrix),H.numLightProbeGrids=k_(b.state.lightProbeGridArray),H.currentProgram=Qt,H.uniformsList=null,Qt}function M3(A,O,Y,H,X){let St=Lt.get(A),Et=St.currentProgram.id+","+H+","+X,bt=St.programVariants.get(Et);return bt===void 0?(bt=fc(A,O,Y),St.programVariants.set(Et,bt)):(St.currentProgram=bt,St.uniformsList=null,St.outputColorSpace=H,St.toneMapping=X),bt}function z_(A){if(A.uniformsList===null){let O=A.currentProgram.getUniforms();A.uniformsList=aa.seqWithValue(O.seq,A.uniforms)}return A.uniformsList}function G_(A,O){let Y=Lt.get(A);Y.outputColorSpace=O.outputColorSpace,Y.batching=O.batching,Y.batchingColor=O.batchingColor,Y.instancing=O.instancing,Y.instancingColor=O.instancingColor,Y.instancingMorph=O.instancingMorph,Y.skinning=O.skinning,Y.morphTargets=O.morphTargets,Y.morphNormals=O.morphNormals,Y.morphColors=O.morphColors,Y.morphTargetsCount=O.morphTargetsCount,Y.numClippingPlanes=O.numClippingPlanes,Y.numIntersection=O.numClipIntersection,Y.vertexAlphas=O.vertexAlphas,Y.vertexTangents=O.vertexTangents,Y.toneMapping=O.toneMapping}function S3(A,O,Y,H,X){O.isScene!==!0&&(O=Ln),Bt.resetTextureUnits();let St=O.fog,Et=H.isMeshStandardMaterial||H.isMeshLambertMaterial||H.isMeshPhongMaterial?O.environment:null,bt=Z===null?E.outputColorSpace:Z.isXRRenderTarget===!0?Z.texture.colorSpace:ee.workingColorSpace,At=H.isMeshStandardMaterial||H.isMeshLambertMaterial&&!H.envMap||H.isMeshPhongMaterial&&!H.envMap,Pt=P.get(H.envMap||Et,At),Vt=H.vertexColors===!0&&!!Y.attributes.color&&Y.attributes.color.itemSize===4,Qt=!!Y.attributes.tangent&&(!!H.normalMap||H.anisotropy>0),Ct=!!Y.morphAttributes.position,te=!!Y.morphAttributes.normal,ke=!!Y.morphAttributes.color,be=Yi;H.toneMapped&&(Z===null||Z.isXRRenderTarget===!0)&&(be=E.toneMapping);let ye=Y.morphAttributes.position||Y.morphAttributes.normal||Y.morphAttributes.color,fn=ye!==void 0?ye.length:0,Rt=Lt.get(H),_n=b.state.lights;if(Gt===!0&&(ce===!0||A!==G)){let Ae=A===G&&H.id===U;tt.setState(H,A,Ae)}let le=!1,Vs=!1;H.version===Rt.__version?Rt.needsLights&&Rt.lightsStateVersion!==_n.state.version||X.isBatchedMesh&&Rt.batching===!1||!X.isBatchedMesh&&Rt.batching===!0||X.isBatchedMesh&&Rt.batchingColor===!0&&X._colorsTexture===null||X.isBatchedMesh&&Rt.batchingColor===!1&&X._colorsTexture!==null||X.isInstancedMesh&&Rt.instancing===!1||!X.isInstancedMesh&&Rt.instancing===!0||X.isSkinnedMesh&&Rt.skinning===!1||!X.isSkinnedMesh&&Rt.skinning===!0||X.isInstancedMesh&&Rt.instancingColor===!0&&X.instanceColor===null||X.isInstancedMesh&&Rt.instancingColor===!1&&X.instanceColor!==null||X.isInstancedMesh&&Rt.instancingMorph===!0&&X.morphTexture===null||X.isInstancedMesh&&Rt.instancingMorph===!1&&X.morphTexture!==null||Rt.envMap!==Pt||H.fog===!0&&Rt.fog!==St||Rt.numClippingPlanes!==void 0&&(Rt.numClippingPlanes!==tt.numPlanes||Rt.numIntersection!==tt.numIntersection)||Rt.vertexAlphas!==Vt||Rt.vertexTangents!==Qt||Rt.morphTargets!==Ct||Rt.morphNormals!==te||Rt.morphColors!==ke||Rt.morphTargetsCount!==fn||Rt.numLightProbeGrids!==k_(b.state.lightProbeGridArray)?le=!0:(Rt.outputColorSpace!==bt||Rt.toneMapping!==be)&&(Vs=!0):(le=!0,Rt.__version=H.version);let hn=Rt.currentProgram;(le===!0||Vs===!0)&&(hn=Vs===!0?M3(H,O,X,bt,be):fc(H,O,X),N&&H.isNodeMaterial&&N.onUpdateProgram(H,hn,Rt));let cu=!1,rs=!1,Hs=!1,re=hn.getUniforms(),on=Rt.uniforms;if(mt.useProgram(hn.program)&&(cu=!0,rs=!0,Hs=!0),H.id!==U&&(U=H.id,rs=!0),cu||G!==A){mt.buffers.depth.getReversed()&&A.reversedDepth!==!0&&(A._reversedDepth=!0,A.updateProjectionMatrix()),re.setValue(z,"projectionMatrix",A.projectionMatrix),re.setValue(z,"viewMatrix",A.matrixWorldInverse);let Ye=re.map.cameraPosition;Ye!==void 0&&Ye.setValue(z,Xe.setFromMatrixPosition(A.matrixWorld)),ve.logarithmicDepthBuffer&&re.setValue(z,"logDepthBufFC",2/(Math.log(A.far+1)/Math.LN2)),(H.isMeshPhongMaterial||H.isMeshToonMaterial||H.isMeshLambertMaterial||H.isMeshBasicMaterial||H.isMeshStandardMaterial||H.isShaderMaterial)&&re.setValue(z,"isOrthographic",A.isOrthographicCamera===!0),G!==A&&(G=A,rs=!0,Hs=!0)}if(Rt.needsLights&&(_n.state.sunShadowMap.length>0&&re.setValue(z,"sunShadowMap",_n.state.sunShadowMap,Bt),_n.state.directionalShadowMap.length>0&&re.setValue(z,"directionalShadowMap",_n.state.directionalShadowMap,Bt),_n.state.spotShadowMap.length>0&&re.setValue(z,"spotShadowMap",_n.state.spotShadowMap,Bt),_n.state.pointShadowMap.length>0&&re.setValue(z,"pointShadowMap",_n.state.pointShadowMap,Bt)),X.isSkinnedMesh){re.setOptional(z,X,"bindMatrix"),re.setOptional(z,X,"bindMatrixInverse");let Ae=X.skeleton;Ae&&(Ae.boneTexture===null&&Ae.computeBoneTexture(),re.setValue(z,"boneTexture",Ae.boneTexture,Bt))}X.isBatchedMesh&&(re.setOptional(z,X,"batchingTexture"),re.setValue(z,"batchingTexture",X._matricesTexture,Bt),re.setOptional(z,X,"batchingIdTexture"),re.setValue(z,"batchingIdTexture",X._indirectTexture,Bt),re.setOptional(z,X,"batchingColorTexture"),X._colorsTexture!==null&&re.setValue(z,"batchingColorTexture",X._colorsTexture,Bt));let Si=Y.morphAttributes;if((Si.position!==void 0||Si.normal!==void 0||Si.color!==void 0)&&et.update(X,Y,hn),(rs||Rt.receiveShadow!==X.receiveShadow)&&(Rt.receiveShadow=X.receiveShadow,re.setValue(z,"receiveShadow",X.receiveShadow)),(H.isMeshStandardMaterial||H.isMeshLambertMaterial||H.isMeshPhongMaterial)&&H.envMap===null&&O.environment!==null&&(on.envMapIntensity.value=O.environmentIntensity),on.dfgLUT!==void 0&&(on.dfgLUT.value=dN()),rs){if(re.setValue(z,"toneMappingExposure",E.toneMappingExposure),Rt.needsLights&&w3(on,Hs),St&&H.fog===!0&&yt.refreshFogUniforms(on,St),yt.refreshMaterialUniforms(on,H,rt,ot,b.state.transmissionRenderTarget[A.id]),Rt.needsLights&&Rt.numLightProbeGrids>0){let Ae=_,Ye=0;for(let vr of b.state.lightProbeGridArray)vr.texture!==null&&(Ae.textures[Ye]=vr.texture,Ae.min[Ye]=vr.boundingBox.min,Ae.max[Ye]=vr.boundingBox.max,Ae.resolution[Ye]=vr.resolution,Ye++);for(let vr in Ae)Ae[vr].length=Ye;on.probesSH.value=Ae.textures,on.probesMin.value=Ae.min,on.probesMax.value=Ae.max,on.probesResolution.value=Ae.resolution}aa.upload(z,z_(Rt),on,Bt)}if(H.isShaderMaterial&&H.uniformsNeedUpdate===!0&&(aa.upload(z,z_(Rt),on,Bt),H.uniformsNeedUpdate=!1),H.isSpriteMaterial&&re.setValue(z,"center",X.center),re.setValue(z,"modelViewMatrix",X.modelViewMatrix),re.setValue(z,"normalMatrix",X.normalMatrix),re.setValue(z,"modelMatrix",X.matrixWorld),H.uniformsGroups!==void 0){let Ae=H.uniformsGroups;for(let Ye=0,vr=Ae.length;Ye<vr;Ye++){let H_=Ae[Ye];Nt.update(H_,hn),Nt.bind(H_,hn)}}return hn}function w3(A,O){A.ambientLightColor.needsUpdate=O,A.lightProbe.needsUpdate=O,A.sunLights.needsUpdate=O,A.sunLightShadows.needsUpdate=O,A.directionalLights.needsUpdate=O,A.directionalLightShadows.needsUpdate=O,A.pointLights.needsUpdate=O,A.pointLightShadows.needsUpdate=O,A.spotLights.needsUpdate=O,A.spotLightShadows.needsUpdate=O,A.rectAreaLights.needsUpdate=O,A.hemisphereLights.needsUpdate=O}function T3(A){return A.isMeshLambertMaterial||A.isMeshToonMaterial||A.isMeshPhongMaterial||A.isMeshStandardMaterial||A.isShadowMaterial||A.isShaderMaterial&&A.lights===!0}this.getActiveCubeFace=function(){return k},this.getActiveMipmapLevel=function(){return F},this.getRenderTarget=function(){return Z},this.setRenderTargetTextures=function(A,O,Y){let H=Lt.get(A);H.__autoAllocateDepthBuffer=A.resolveDepthBuffer===!1,H.__autoAllocateDepthBuffer===!1&&(H.__useRenderToTexture=!1),Lt.get(A.texture).__webglTexture=O,Lt.get(A.depthTexture).__webglTexture=H.__autoAllocateDepthBuffer?void 0:Y,H.__hasExternalTextures=!0},this.setRenderTargetFramebuffer=function(A,O){let Y=Lt.get(A);Y.__webglFramebuffer=O,Y.__useDefaultFramebuffer=O===void 0},this.setRenderTarget=function(A,O=0,Y=0){Z=A,k=O,F=Y;let H=null,X=!1,St=!1;if(A){let bt=Lt.get(A);if(bt.__useDefaultFramebuffer!==void 0){mt.bindFramebuffer(z.FRAMEBUFFER,bt.__webglFramebuffer),q.copy(A.viewport),st.copy(A.scissor),ct=A.scissorTest,mt.viewport(q),mt.scissor(st),mt.setScissorTest(ct),U=-1;return}else if(bt.__webglFramebuffer===void 0)Bt.setupRenderTarget(A);else if(bt.__hasExternalTextures)Bt.rebindTextures(A,Lt.get(A.texture).__webglTexture,Lt.get(A.depthTexture).__webglTexture);else if(A.depthBuffer){let Vt=A.depthTexture;if(bt.__boundDepthTexture!==Vt){if(Vt!==null&&Lt.has(Vt)&&(A.width!==Vt.image.width||A.height!==Vt.image.height))throw new Error("THREE.WebGLRenderer: Attached DepthTexture is initialized to the incorrect size.");Bt.setupDepthRenderbuffer(A)}}let At=A.texture;(At.isData3DTexture||At.isDataArrayTexture||At.isCompressedArrayTexture)&&(St=!0);let Pt=Lt.get(A).__webglFramebuffer;A.isWebGLCubeRenderTarget?(Array.isArray(Pt[O])?H=Pt[O][Y]:H=Pt[O],X=!0):A.samples>0&&Bt.useMultisampledRTT(A)===!1?H=Lt.get(A).__webglMultisampledFramebuffer:Array.isArray(Pt)?H=Pt[Y]:H=Pt,q.copy(A.viewport),st.copy(A.scissor),ct=A.scissorTest}else q.copy(lt).multiplyScalar(rt).floor(),st.copy(K).multiplyScalar(rt).floor(),ct=It;if(Y!==0&&(H=B),mt.bindFramebuffer(z.FRAMEBUFFER,H)&&mt.drawBuffers(A,H),mt.viewport(q),mt.scissor(st),mt.setScissorTest(ct),X){let bt=Lt.get(A.texture);z.framebufferTexture2D(z.FRAMEBUFFER,z.COLOR_ATTACHMENT0,z.TEXTURE_CUBE_MAP_POSITIVE_X+O,bt.__webglTexture,Y)}else if(St){let bt=O;for(let At=0;At<A.textures.length;At++){let Pt=Lt.get(A.textures[At]);z.framebufferTextureLayer(z.FRAMEBUFFER,z.COLOR_ATTACHMENT0+At,Pt.__webglTexture,Y,bt)}}else if(A!==null&&Y!==0){let bt=Lt.get(A.texture);z.framebufferTexture2D(z.FRAMEBUFFER,z.COLOR_ATTACHMENT0,z.TEXTURE_2D,bt.__webglTexture,Y)}U=-1};function V_(A){let O=Lt.get(A);return(O.__readFormat!==A.format||O.__readType!==A.type)&&(O.__readFormat=A.format,O.__readType=A.type,O.__formatReadable=ve.textureFormatReadable(A.format),O.__typeReadable=ve.textureTypeReadable(A.type)),O}this.readRenderTargetPixels=function(A,O,Y,H,X,St,Et,bt=0){if(!(A&&A.isWebGLRenderTarget)){kt("WebGLRenderer.readRenderTargetPixels: renderTarget is not THREE.WebGLRenderTarget.");return}let At=Lt.get(A).__webglFramebuffer;if(A.isWebGLCubeRenderTarget&&Et!==void 0&&(At=At[Et],Array.isArray(At)&&(At=At[0])),At){mt.bindFramebuffer(z.FRAMEBUFFER,At);try{let Pt=A.textures[bt],Vt=Pt.format,Qt=Pt.type;A.textures.length>1&&z.readBuffer(z.COLOR_ATTACHMENT0+bt);let Ct=V_(Pt);if(Ct.__formatReadable===!1){kt("WebGLRenderer.readRenderTargetPixels: renderTarget is not in RGBA or implementation defined format.");return}if(Ct.__typeReadable===!1){kt("WebGLRenderer.readRenderTargetPixels: renderTarget is not in UnsignedByteType or implementation defined type.");return}O>=0&&O<=A.width-H&&Y>=0&&Y<=A.height-X&&z.readPixels(O,Y,H,X,dt.convert(Vt),dt.convert(Qt),St)}finally{let Pt=Z!==null?Lt.get(Z).__webglFramebuffer:null;mt.bindFramebuffer(z.FRAMEBUFFER,Pt)}}},this.readRenderTargetPixelsAsync=async function(A,O,Y,H,X,St,Et,bt=0){if(!(A&&A.isWebGLRenderTarget))throw new Error("THREE.WebGLRenderer.readRenderTargetPixels: renderTarget is not THREE.WebGLRenderTarget.");let At=Lt.get(A).__webglFramebuffer;if(A.isWebGLCubeRenderTarget&&Et!==void 0&&(At=At[Et],Array.isArray(At)&&(At=At[0])),At)if(O>=0&&O<=A.width-H&&Y>=0&&Y<=A.height-X){mt.bindFramebuffer(z.FRAMEBUFFER,At);let Pt=A.textures[bt],Vt=Pt.format,Qt=Pt.type;A.textures.length>1&&z.readBuffer(z.COLOR_ATTACHMENT0+bt);let Ct=V_(Pt);if(Ct.__formatReadable===!1)throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: renderTarget is not in RGBA or implementation defined format.");if(Ct.__typeReadable===!1)throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: renderTarget is not in UnsignedByteType or implementation defined type.");let te=z.createBuffer();z.bindBuffer(z.PIXEL_PACK_BUFFER,te),z.bufferData(z.PIXEL_PACK_BUFFER,St.byteLength,z.STREAM_READ),z.readPixels(O,Y,H,X,dt.convert(Vt),dt.convert(Qt),0),z.bindBuffer(z.PIXEL_PACK_BUFFER,null);let ke=Z!==null?Lt.get(Z).__webglFramebuffer:null;mt.bindFramebuffer(z.FRAMEBUFFER,ke);let be=z.fenceSync(z.SYNC_GPU_COMMANDS_COMPLETE,0);return z.flush(),await rb(z,be,4),z.bindBuffer(z.PIXEL_PACK_BUFFER,te),z.getBufferSubData(z.PIXEL_PACK_BUFFER,0,St),z.bindBuffer(z.PIXEL_PACK_BUFFER,null),z.deleteBuffer(te),z.deleteSync(be),St}else throw new Error("THREE.WebGLRenderer.readRenderTargetPixelsAsync: requested read bounds are out of range.")},this.copyFramebufferToTexture=function(A,O=null,Y=0){let H=Math.pow(2,-Y),X=Math.floor(A.image.width*H),St=Math.floor(A.image.height*H),Et=O!==null?O.x:0,bt=O!==null?O.y:0;Bt.setTexture2D(A,0),z.copyTexSubImage2D(z.TEXTURE_2D,Y,0,0,Et,bt,X,St),mt.unbindTexture()},this.copyTextureToTexture=function(A,O,Y=null,H=null,X=0,St=0){let Et,bt,At,Pt,Vt,Qt,Ct,te,ke,be=A.isCompressedTexture?A.mipmaps[St]:A.image;if(Y!==null)Et=Y.max.x-Y.min.x,bt=Y.max.y-Y.min.y,At=Y.isBox3?Y.max.z-Y.min.z:1,Pt=Y.min.x,Vt=Y.min.y,Qt=Y.isBox3?Y.min.z:0;else{let re=Math.pow(2,-X);Et=Math.floor(be.width*re),bt=Math.floor(be.height*re),A.isDataArrayTexture?At=be.depth:A.isData3DTexture?At=Math.floor(be.depth*re):At=1,Pt=0,Vt=0,Qt=0}H!==null?(Ct=H.x,te=H.y,ke=H.z):(Ct=0,te=0,ke=0);let ye=dt.convert(O.format),fn=dt.convert(O.type),Rt;O.isData3DTexture?(Bt.setTexture3D(O,0),Rt=z.TEXTURE_3D):O.isDataArrayTexture||O.isCompressedArrayTexture?(Bt.setTexture2DArray(O,0),Rt=z.TEXTURE_2D_ARRAY):(Bt.setTexture2D(O,0),Rt=z.TEXTURE_2D),mt.activeTexture(z.TEXTURE0),mt.pixelStorei(z.UNPACK_FLIP_Y_WEBGL,O.flipY),mt.pixelStorei(z.UNPACK_PREMULTIPLY_ALPHA_WEBGL,O.premultiplyAlpha),mt.pixelStorei(z.UNPACK_ALIGNMENT,O.unpackAlignment);let _n=mt.getParameter(z.UNPACK_ROW_LENGTH),le=mt.getParameter(z.UNPACK_IMAGE_HEIGHT),Vs=mt.getParameter(z.UNPACK_SKIP_PIXELS),hn=mt.getParameter(z.UNPACK_SKIP_ROWS),cu=mt.getParameter(z.UNPACK_SKIP_IMAGES);mt.pixelStorei(z.UNPACK_ROW_LENGTH,be.width),mt.pixelStorei(z.UNPACK_IMAGE_HEIGHT,be.height),mt.pixelStorei(z.UNPACK_SKIP_PIXELS,Pt),mt.pixelStorei(z.UNPACK_SKIP_ROWS,Vt),mt.pixelStorei(z.UNPACK_SKIP_IMAGES,Qt);let rs=A.isDataArrayTexture||A.isData3DTexture,Hs=O.isDataArrayTexture||O.isData3DTexture;if(A.isDepthTexture){let re=Lt.get(A),on=Lt.get(O),Si=Lt.get(re.__renderTarget),Ae=Lt.get(on.__renderTarget);mt.bindFramebuffer(z.READ_FRAMEBUFFER,Si.__webglFramebuffer),mt.bindFramebuffer(z.DRAW_FRAMEBUFFER,Ae.__webglFramebuffer);for(let Ye=0;Ye<At;Ye++)rs&&(z.framebufferTextureLayer(z.READ_FRAMEBUFFER,z.COLOR_ATTACHMENT0,Lt.get(A).__webglTexture,X,Qt+Ye),z.framebufferTextureLayer(z.DRAW_FRAMEBUFFER,z.COLOR_ATTACHMENT0,Lt.get(O).__webglTexture,St,ke+Ye)),z.blitFramebuffer(Pt,Vt,Pt+Et,Vt+bt,Ct,te,Ct+Et,te+bt,z.DEPTH_BUFFER_BIT,z.NEAREST);mt.bindFramebuffer(z.READ_FRAMEBUFFER,null),mt.bindFramebuffer(z.DRAW_FRAMEBUFFER,null)}else if(X!==0||A.isRenderTargetTexture||Lt.has(A)){let re=Lt.get(A),on=Lt.get(O);mt.bindFramebuffer(z.READ_FRAMEBUFFER,I),mt.bindFramebuffer(z.DRAW_FRAMEBUFFER,L);for(let Si=0;Si<At;Si++)rs?z.framebufferTextureLayer(z.READ_FRAMEBUFFER,z.COLOR_ATTACHMENT0,re.__webglTexture,X,Qt+Si):z.framebufferTexture2D(z.READ_FRAMEBUFFER,z.COLOR_ATTACHMENT0,z.TEXTURE_2D,re.__webglTexture,X),Hs?z.framebufferTextureLayer(z.DRAW_FRAMEBUFFER,z.COLOR_ATTACHMENT0,on.__webglTexture,St,ke+Si):z.framebufferTexture2D(z.DRAW_FRAMEBUFFER,z.COLOR_ATTACHMENT0,z.TEXTURE_2D,on.__webglTexture,St),X!==0?z.blitFramebuffer(Pt,Vt,Pt+Et,Vt+bt,Ct,te,Ct+Et,te+bt,z.COLOR_BUFFER_BIT,z.NEAREST):Hs?z.copyTexSubImage3D(Rt,St,Ct,te,ke+Si,Pt,Vt,Et,bt):z.copyTexSubImage2D(Rt,St,Ct,te,Pt,Vt,Et,bt);mt.bindFramebuffer(z.READ_FRAMEBUFFER,null),mt.bindFramebuffer(z.DRAW_FRAMEBUFFER,null)}else Hs?A.isDataTexture||A.isData3DTexture?z.texSubImage3D(Rt,St,Ct,te,ke,Et,bt,At,ye,fn,be.data):O.isCompressedArrayTexture?z.compressedTexSubImage3D(Rt,St,Ct,te,ke,Et,bt,At,ye,be.data):z.texSubImage3D(Rt,St,Ct,te,ke,Et,bt,At,ye,fn,be):A.isDataTexture?z.texSubImage2D(z.TEXTURE_2D,St,Ct,te,Et,bt,ye,fn,be.data):A.isCompressedTexture?z.compressedTexSubImage2D(z.TEXTURE_2D,St,Ct,te,be.width,be.height,ye,be.data):z.texSubImage2D(z.TEXTURE_2D,St,Ct,te,Et,bt,ye,fn,be);mt.pixelStorei(z.UNPACK_ROW_LENGTH,_n),mt.pixelStorei(z.UNPACK_IMAGE_HEIGHT,le),mt.pixelStorei(z.UNPACK_SKIP_PIXELS,Vs),mt.pixelStorei(z.UNPACK_SKIP_ROWS,hn),mt.pixelStorei(z.UNPACK_SKIP_IMAGES,cu),St===0&&O.generateMipmaps===!0&&O.mipmapsAutoUpdate===!0&&z.generateMipmap(Rt),mt.unbindTexture()},this.initRenderTarget=function(A){Lt.get(A).__webglFramebuffer===void 0&&Bt.setupRenderTarget(A)},this.initTexture=function(A){A.isCubeTexture?Bt.setTextureCube(A,0):A.isData3DTexture?Bt.setTexture3D(A,0):A.isDataArrayTexture||A.isCompressedArrayTexture?Bt.setTexture2DArray(A,0):Bt.setTexture2D(A,0),mt.unbindTexture()},this.resetState=function(){k=0,F=0,Z=null,mt.reset(),xt.reset()},typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}get coordinateSystem(){return ii}get outputColorSpace(){return this._outputColorSpace}set outputColorSpace(t){this._outputColorSpace=t;let n=this.getContext();n.drawingBufferColorSpace=ee._getDrawingBufferColorSpace(t),n.unpackColorSpace=ee._getUnpackColorSpace()}};var la=new Sn,Wb=new Sn;function Kc({frames:e,bodies:t,orientations:n,positions:i},r){if(e===0)return[];let s=Math.min(Math.max(Math.floor(r),0),e-1),o=Math.min(s+1,e-1),a=Math.min(Math.max(r-s,0),1);return Array.from({length:t},(c,l)=>{let[u,h]=[s*t+l,o*t+l];la.set(n[4*u+1],n[4*u+2],n[4*u+3],n[4*u]),Wb.set(n[4*h+1],n[4*h+2],n[4*h+3],n[4*h]),a>0&&la.normalize().slerp(Wb.normalize(),a);let f=d=>i[3*u+d]+a*(i[3*h+d]-i[3*u+d]);return[la.w,la.x,la.y,la.z,f(0),f(1),f(2)]})}var pN=240,mN=.6,gN=.1;function $b({shapes:e,objects:t,motions:n}){let i=Object.fromEntries(Object.entries(e).map(([l,u])=>[l,u.map(xN)])),r=Math.max(2,Math.ceil(pN/n.size)),s=[...n.values()].flatMap(l=>Object.entries(l.hands).flatMap(([u,h])=>Xb(h,r).flatMap(f=>zm(i[u]??[],f)))),o=new Un().setFromPoints(s),a=o.getCenter(new W),c=yN(t,n,r).filter(l=>l.distanceTo(a)<mN&&l.z>o.min.z-gN);return[...s,...c]}function yN(e,t,n){let i=o=>o.role==="surface"?[]:_N(o),r=e.filter(({moves:o})=>o).map(i),s=e.filter(({moves:o})=>!o);return[...zm(s.map(i),s.map(({pose:o})=>o)),...[...t.values()].flatMap(o=>Xb(o.objects,n)).flatMap(o=>zm(r,o))]}function Xb(e,t){let n=Math.min(t,e.frames);return Array.from({length:n},(i,r)=>Kc(e,r*(e.frames-1)/Math.max(n-1,1)))}function zm(e,t){return t.flatMap(([n,i,r,s,...o],a)=>{if(![n,i,r,s,...o].every(Number.isFinite))return[];let c=new Sn(i,r,s,n),l=new W(...o);return(e[a]??[]).map(u=>u.clone().applyQuaternion(c).add(l))})}function xN({vertices:e}){return e.length===0?[]:qb(new Un().setFromBufferAttribute(new bn(e,3)))}function _N({half_sizes:e}){let t=new W(...e);return qb(new Un(t.clone().negate(),t))}function qb({min:e,max:t}){return[e.x,t.x].flatMap(n=>[e.y,t.y].flatMap(i=>[e.z,t.z].map(r=>new W(n,i,r))))}var vN={cylinder:()=>new Pc(1,1,2,48).rotateX(Math.PI/2),sphere:()=>new Lc(1,40,24),box:()=>new ds(2,2,2),plane:()=>new Ys(2,2)},bN={polygonOffsetFactor:2,polygonOffsetUnits:2};function Yb(e,t){let n=t<1?{transparent:!0,opacity:t,polygonOffset:!0,...bN}:{},i=new ta(n),r=new Ar;for(let{vertices:s,faces:o}of e){let a=new ri;a.setAttribute("position",new bn(s,3)),a.setIndex(new bn(o,1)),a.computeVertexNormals(),r.add(new Yn(a,i))}return r.renderOrder=t<1?2:1,{group:r,material:i}}function Zb({kind:e,half_sizes:t,moves:n,pose:i}){let r=vN[e]().scale(...t.map(a=>a||1)),s=new ta(e==="plane"?{side:si}:{}),o=new Yn(r,s);return n||sh(o,i),{body:o,material:s}}function sh(e,[t,n,i,r,s,o,a]){e.visible=[t,n,i,r,s,o,a].every(Number.isFinite),e.visible&&(e.quaternion.set(n,i,r,t),e.position.set(s,o,a))}var MN=1.06,SN=[new W(-.1,-.1,-.1),new W(.1,.1,.1)];function Kb(e,t){let n=e.length>0?e:SN,i=new W(0,0,1).cross(t).normalize(),r=[i,t.clone().cross(i),t],s=n.map(f=>new W(...r.map(d=>d.dot(f)))),o=new Un().setFromPoints(s).getCenter(new W),a=s.map(f=>f.sub(o)),[c,l,u]=o.toArray();return{middle:t.clone().multiplyScalar(u).addScaledVector(r[0],c).addScaledVector(r[1],l),radius:Jb(a,f=>f.length()),distance(f,d){let p=Math.tan(Tm.degToRad(f/2));return MN*Jb(a,({x:m,y:g,z:v})=>v+Math.max(Math.abs(m)/(p*d),Math.abs(g)/p))}}}function Jb(e,t){return e.reduce((n,i)=>Math.max(n,t(i)),0)}var wN=.008,oh=.12,Gm=1.15,jb=1.5;function e1(e,t,n,i,r){let s=TN(new W(...i)),o=Kb(n,Qb(s)),a={...s,zoom:1},c=new Map;function l(){let p=o.distance(t.fov,t.aspect)/a.zoom;t.position.copy(o.middle).addScaledVector(Qb(a),p),t.near=Math.max(p-4*o.radius,p/100),t.far=p+6*o.radius,t.up.set(0,0,1),t.lookAt(o.middle),t.updateProjectionMatrix(),r()}function u(p,y){a.azimuth-=p,a.elevation=Math.min(jb,Math.max(-jb,a.elevation+y)),l()}function h(p){a.zoom=Math.min(8,Math.max(.4,a.zoom*p)),l()}function f(){Object.assign(a,s,{zoom:1}),l()}let d={ArrowLeft:()=>u(-oh,0),ArrowRight:()=>u(oh,0),ArrowUp:()=>u(0,oh),ArrowDown:()=>u(0,-oh),"+":()=>h(Gm),"=":()=>h(Gm),"-":()=>h(1/Gm),Home:f};e.addEventListener("keydown",p=>{!d[p.key]||p.ctrlKey||p.metaKey||p.altKey||(d[p.key](),p.preventDefault())}),e.addEventListener("pointerdown",p=>{e.setPointerCapture(p.pointerId),c.set(p.pointerId,[p.clientX,p.clientY])}),e.addEventListener("pointermove",p=>{let y=c.get(p.pointerId);if(!y)return;let m=t1(c);c.set(p.pointerId,[p.clientX,p.clientY]);let g=wN/c.size;u((p.clientX-y[0])*g,(p.clientY-y[1])*g),m>0&&h(t1(c)/m)});for(let p of["pointerup","pointercancel"])e.addEventListener(p,y=>c.delete(y.pointerId));return e.addEventListener("wheel",p=>{!p.ctrlKey&&document.activeElement!==e||(p.preventDefault(),h(Math.exp(-p.deltaY/500)))},{passive:!1}),{show:l,reset:f}}function Qb({azimuth:e,elevation:t}){let n=Math.cos(t);return new W(n*Math.cos(e),n*Math.sin(e),Math.sin(t))}function TN(e){let t=e.normalize().negate();return{azimuth:Math.atan2(t.y,t.x),elevation:Math.asin(t.z)}}function t1(e){if(e.size<2)return 0;let[[t,n],[i,r]]=[...e.values()];return Math.hypot(t-i,n-r)}function n1(e,t){let n=Math.min(devicePixelRatio,2),i=n,r=n,s=0,o=-1/0,a=0;function c(){e.getPixelRatio()!==r&&e.setPixelRatio(r)}function l(){r=n,s=0,o=-1/0,t()}function u(f){if(s=s===0?f:.8*s+(1-.8)*f,s>50&&i>.5){let d=Math.min(.9,Math.sqrt(50/s));i=Math.max(.5,i*d),s=0}r=i}function h(){let f=performance.now(),d=f-o;o=f,d<300&&u(d),clearTimeout(a),r<n&&(a=setTimeout(l,300))}return{prepare:c,drawn:h}}var AN={truth:1,estimate:.55},EN=.25;function i1(){return document.createElement("canvas").getContext("webgl2")!==null}function r1(e,{shapes:t,objects:n,view:i},r){let s=new nh({antialias:!0,alpha:!0,preserveDrawingBuffer:!0});e.append(s.domElement);let o=new Tc,a=new vn(26,1);o.add(a,new Bc(16777215,1.5));let c=new Oc(16777215,2.2);c.position.set(-.6,.9,.7),a.add(c);let l=Object.entries(t).map(([S,_])=>({name:S,...Yb(_,AN[S]??1)})),u=n.map(S=>({...S,...Zb(S)}));l.forEach(({group:S})=>o.add(S)),u.forEach(({body:S})=>o.add(S));let h=u.filter(({moves:S})=>S),f=0,d=!1,p=n1(s,y);function y(){d=!1,p.prepare(),s.render(o,a),f+=1,e.dataset.frames=f,p.drawn()}function m(){d||requestAnimationFrame(y),d=!0}function g(){for(let{name:_,material:w}of l)w.color=new Zt(uu(`hand-${_}`));let S=new Zt(uu("paper"));for(let{role:_,material:w}of u)w.color=new Zt(uu(_==="plain"?"surface":_)).lerp(S,EN);y()}W_(g);let v=e1(e,a,r,i,m);return g(),new ResizeObserver(()=>{let{clientWidth:S,clientHeight:_}=e;S===0||_===0||(s.setSize(S,_,!1),a.aspect=S/_,v.show(),y())}).observe(e),{showFrame(S,_){for(let{name:w,group:b}of l)(S[w]??[]).forEach((x,M)=>b.children[M]&&sh(b.children[M],x)),S[w]||b.children.forEach(x=>{x.visible=!1});_.forEach((w,b)=>h[b]&&sh(h[b].body,w)),m()},showHand(S,_){l.filter(w=>w.name===S).forEach(({group:w})=>{w.visible=_}),m()},reset:v.reset}}var CN="12px system-ui, sans-serif",s1=document.createElement("canvas").getContext("2d");s1.font=CN;function an(e){return s1.measureText(e).width}function ah(e){let t=[...e.querySelectorAll('[aria-label="y-axis tick label"] text')];return Math.max(0,...t.map(({textContent:n})=>an(n)))}function Dr(e,t){if(an(e)<=t)return e;let n=e.length-1;for(;n>0&&an(`${e.slice(0,n)}…`)>t;)n-=1;return`${e.slice(0,n).trimEnd()}…`}function jc(e,t){let n=e.lastIndexOf(", ");return n<0?`${e} ${t}`:`${e.slice(0,n)} ${t} ${e.slice(n+2)}`}function Fr(e,t=4){return Number.isFinite(e)?String(Number(e.toPrecision(t))).replace("-","−"):"none"}function o1(e,t=3){return!Number.isFinite(e)||Number.isInteger(e)||Math.abs(e)>=10**t?Fr(e,t):e.toPrecision(t).replace("-","−")}var ch=10,a1=15,RN=1.12;function Ki(e){return Ht("ul",{class:"key"},...e.map(({name:t,role:n,style:i})=>{let r=Ht("span",{class:`swatch ${i}`});return r.style.setProperty("--of",Ze(n)),Ht("li",{},r,t)}))}function Vm(e){return 18+ch+RN*Math.max(...e.map(({name:t})=>an(t)))}function c1(e,t,n){let i=e.map((a,c)=>({at:a,i:c})).sort((a,c)=>a.at-c.at),r=i.map(({at:a})=>a);for(let a=1;a<r.length;a+=1)r[a]=Math.max(r[a],r[a-1]+a1);let s=n;for(let a=r.length-1;a>=0;a-=1)r[a]=Math.max(t,Math.min(r[a],s)),s=r[a]-a1;let o=[];return i.forEach(({i:a},c)=>{o[a]=r[c]}),o}var IN=[.1,.25,.5,1,2],PN={truth:"true hand",estimate:"as the tracker had it"};function l1(e,t,n){if(!i1())return e.replaceWith(Ht("p",{class:"notice"},"This browser does not draw in three dimensions (WebGL 2 is off).")),null;e.tabIndex=0,e.setAttribute("role","application"),e.setAttribute("aria-roledescription","hand that can be turned: arrows turn, plus and minus zoom, Home resets");let i=r1(e,t,$b(t)),r=Ht("div",{class:"tools"},DN(t,i),Ht("button",{type:"button",class:"quiet",onclick:i.reset},"Reset view"));return J_(e),e.parentElement.before(r),n&&(e.parentElement.after(NN(n)),LN(e,t,n,i)),i}function LN(e,{motions:t},n,i){let r=Ht("p",{class:"gone",hidden:!0},"The hand's motion in this trial is not in this report.");e.parentElement.after(r);function s(){let a=t.get(n.state.trial);if(!a)return;let c=(n.state.time-a.start)/a.step,l=Object.fromEntries(Object.entries(a.hands).map(([u,h])=>[u,Kc(h,c)]));i.showFrame(l,Kc(a.objects,c))}function o(){let a=t.get(n.state.trial);if(r.hidden=a!==void 0,!a){n.pause(),n.setSpan(0,0),i.showFrame({},[]);return}n.setSpan(a.start,a.start+a.step*Math.max(j_(a)-1,0)),n.seek(n.state.span[0])}n.listen(a=>{a==="time"&&s(),a==="trial"&&o()}),e.addEventListener("keydown",a=>{a.key===" "&&(n.toggle(),a.preventDefault())}),o()}function NN(e){let t=Ht("input",{type:"range",min:0,max:1e3,value:0,step:1,"aria-label":"Time in the trial"});t.addEventListener("input",()=>{let[i,r]=e.state.span;e.seek(i+(r-i)*t.value/1e3)}),e.listen((i,{time:r,span:[s,o]})=>{i!=="time"&&i!=="span"||(t.value=o>s?Math.round(1e3*(r-s)/(o-s)):0,t.setAttribute("aria-valuetext",`${r.toFixed(2)} s of ${o.toFixed(2)} s`))});let n=Ht("select",{"aria-label":"Speed"},...IN.map(i=>Ht("option",{value:i,selected:i===e.state.speed},`${i} ×`)));return n.addEventListener("change",()=>e.setSpeed(Number(n.value))),Ht("div",{class:"transport"},bp(e),t,Mp(e),n)}function DN({shapes:e},t){let n=Object.keys(e),i=Ki(n.map(r=>({name:PN[r]??r,role:`hand-${r}`,style:"patch"})));return[...i.children].forEach((r,s)=>{let o=Ht("input",{type:"checkbox",checked:!0});o.addEventListener("change",()=>t.showHand(n[s],o.checked)),r.replaceChildren(Ht("label",{},o,...r.childNodes))}),i}function u1(e){let{trials:t,shown:n,at:i,parts:r,arrays:s}=JSON.parse(e),o=s.map(()=>null),a=c=>o[c]??=FN(s[c]);return{trials:t,shown:n,at:i,parts:new Map(Object.entries(r)),array:a}}function FN(e){if("count"in e)return UN(e.from,e.to,e.count);if("f8"in e)return new Float64Array(Hm(e.f8));if("u4"in e)return new Uint32Array(Hm(e.u4));let t=new Int16Array(Hm(e.i2));return Float64Array.from(t,n=>n===-32768?NaN:e.low+(n+32767)*e.step)}function UN(e,t,n){return Float64Array.from({length:n},(i,r)=>e+(t-e)*r/(n-1))}function Hm(e){return Uint8Array.from(atob(e),t=>t.charCodeAt(0)).buffer}function gn(e,t){return e==null||t==null?NaN:e<t?-1:e>t?1:e>=t?0:NaN}function Or(e,t){return e==null||t==null?NaN:t<e?-1:t>e?1:t>=e?0:NaN}function pa(e){let t,n,i;e.length!==2?(t=gn,n=(a,c)=>gn(e(a),c),i=(a,c)=>e(a)-c):(t=e===gn||e===Or?e:ON,n=e,i=e);function r(a,c,l=0,u=a.length){if(l<u){if(t(c,c)!==0)return u;do{let h=l+u>>>1;n(a[h],c)<0?l=h+1:u=h}while(l<u)}return l}function s(a,c,l=0,u=a.length){if(l<u){if(t(c,c)!==0)return u;do{let h=l+u>>>1;n(a[h],c)<=0?l=h+1:u=h}while(l<u)}return l}function o(a,c,l=0,u=a.length){let h=r(a,c,l,u-1);return h>l&&i(a[h-1],c)>-i(a[h],c)?h-1:h}return{left:r,center:o,right:s}}function ON(){return 0}function f1(e){return e===null?NaN:+e}function*BN(e,t){if(t===void 0)for(let n of e)n!=null&&(n=+n)>=n&&(yield n);else{let n=-1;for(let i of e)(i=t(i,++n,e))!=null&&(i=+i)>=i&&(yield i)}}var h1=pa(gn),ma=h1.right,gG=h1.left,yG=pa(f1).center;var xG=d1(p1),_G=d1(kN);function d1(e){return function(t,n,i=n){if(!((n=+n)>=0))throw new RangeError("invalid rx");if(!((i=+i)>=0))throw new RangeError("invalid ry");let{data:r,width:s,height:o}=t;if(!((s=Math.floor(s))>=0))throw new RangeError("invalid width");if(!((o=Math.floor(o!==void 0?o:r.length/s))>=0))throw new RangeError("invalid height");if(!s||!o||!n&&!i)return t;let a=n&&e(n),c=i&&e(i),l=r.slice();return a&&c?(ua(a,l,r,s,o),ua(a,r,l,s,o),ua(a,l,r,s,o),fa(c,r,l,s,o),fa(c,l,r,s,o),fa(c,r,l,s,o)):a?(ua(a,r,l,s,o),ua(a,l,r,s,o),ua(a,r,l,s,o)):c&&(fa(c,r,l,s,o),fa(c,l,r,s,o),fa(c,r,l,s,o)),t}}function ua(e,t,n,i,r){for(let s=0,o=i*r;s<o;)e(t,n,s,s+=i,1)}function fa(e,t,n,i,r){for(let s=0,o=i*r;s<i;++s)e(t,n,s,s+o,i)}function kN(e){let t=p1(e);return(n,i,r,s,o)=>{r<<=2,s<<=2,o<<=2,t(n,i,r+0,s+0,o),t(n,i,r+1,s+1,o),t(n,i,r+2,s+2,o),t(n,i,r+3,s+3,o)}}function p1(e){let t=Math.floor(e);if(t===e)return zN(e);let n=e-t,i=2*e+1;return(r,s,o,a,c)=>{if(!((a-=c)>=o))return;let l=t*s[o],u=c*t,h=u+c;for(let f=o,d=o+u;f<d;f+=c)l+=s[Math.min(a,f)];for(let f=o,d=a;f<=d;f+=c)l+=s[Math.min(a,f+u)],r[f]=(l+n*(s[Math.max(o,f-h)]+s[Math.min(a,f+h)]))/i,l-=s[Math.max(o,f-u)]}}function zN(e){let t=2*e+1;return(n,i,r,s,o)=>{if(!((s-=o)>=r))return;let a=e*i[r],c=o*e;for(let l=r,u=r+c;l<u;l+=o)a+=i[Math.min(s,l)];for(let l=r,u=s;l<=u;l+=o)a+=i[Math.min(s,l+c)],n[l]=a/t,a-=i[Math.max(r,l-c)]}}function Xm(e,t){let n=0;if(t===void 0)for(let i of e)i!=null&&(i=+i)>=i&&++n;else{let i=-1;for(let r of e)(r=t(r,++i,e))!=null&&(r=+r)>=r&&++n}return n}function GN(e){return e.length|0}function VN(e){return!(e>0)}function HN(e){return typeof e!="object"||"length"in e?e:Array.from(e)}function WN(e){return t=>e(...t)}function m1(...e){let t=typeof e[e.length-1]=="function"&&WN(e.pop());e=e.map(HN);let n=e.map(GN),i=e.length-1,r=new Array(i+1).fill(0),s=[];if(i<0||n.some(VN))return s;for(;;){s.push(r.map((a,c)=>e[c][a]));let o=i;for(;++r[o]===n[o];){if(o===0)return t?s.map(t):s;r[o--]=0}}}function g1(e,t){var n=0,i=0;return Float64Array.from(e,t===void 0?r=>n+=+r||0:r=>n+=+t(r,i++,e)||0)}function qm(e,t){let n=0,i,r=0,s=0;if(t===void 0)for(let o of e)o!=null&&(o=+o)>=o&&(i=o-r,r+=i/++n,s+=i*(o-r));else{let o=-1;for(let a of e)(a=t(a,++o,e))!=null&&(a=+a)>=a&&(i=a-r,r+=i/++n,s+=i*(a-r))}if(n>1)return s/(n-1)}function Ym(e,t){let n=qm(e,t);return n&&Math.sqrt(n)}function cn(e,t){let n,i;if(t===void 0)for(let r of e)r!=null&&(n===void 0?r>=r&&(n=i=r):(n>r&&(n=r),i<r&&(i=r)));else{let r=-1;for(let s of e)(s=t(s,++r,e))!=null&&(n===void 0?s>=s&&(n=i=s):(n>s&&(n=s),i<s&&(i=s)))}return[n,i]}var oi=class{constructor(){this._partials=new Float64Array(32),this._n=0}add(t){let n=this._partials,i=0;for(let r=0;r<this._n&&r<32;r++){let s=n[r],o=t+s,a=Math.abs(t)<Math.abs(s)?t-(o-s):s-(o-t);a&&(n[i++]=a),t=o}return n[i]=t,this._n=i+1,this}valueOf(){let t=this._partials,n=this._n,i,r,s,o=0;if(n>0){for(o=t[--n];n>0&&(i=o,r=t[--n],o=i+r,s=r-(o-i),!s););n>0&&(s<0&&t[n-1]<0||s>0&&t[n-1]>0)&&(r=s*2,i=o+r,r==i-o&&(o=i))}return o}};var ai=class extends Map{constructor(t,n=_1){if(super(),Object.defineProperties(this,{_intern:{value:new Map},_key:{value:n}}),t!=null)for(let[i,r]of t)this.set(i,r)}get(t){return super.get(Wm(this,t))}has(t){return super.has(Wm(this,t))}set(t,n){return super.set(y1(this,t),n)}delete(t){return super.delete(x1(this,t))}},ji=class extends Set{constructor(t,n=_1){if(super(),Object.defineProperties(this,{_intern:{value:new Map},_key:{value:n}}),t!=null)for(let i of t)this.add(i)}has(t){return super.has(Wm(this,t))}add(t){return super.add(y1(this,t))}delete(t){return super.delete(x1(this,t))}};function Wm({_intern:e,_key:t},n){let i=t(n);return e.has(i)?e.get(i):n}function y1({_intern:e,_key:t},n){let i=t(n);return e.has(i)?e.get(i):(e.set(i,n),n)}function x1({_intern:e,_key:t},n){let i=t(n);return e.has(i)&&(n=e.get(i),e.delete(i)),n}function _1(e){return e!==null&&typeof e=="object"?e.valueOf():e}function $m(e){return e}function to(e,...t){return Zm(e,$m,$m,t)}function Br(e,t,...n){return Zm(e,$m,t,n)}function v1(e,t,...n){return Zm(e,Array.from,t,n)}function Zm(e,t,n,i){return(function r(s,o){if(o>=i.length)return n(s);let a=new ai,c=i[o++],l=-1;for(let u of s){let h=c(u,++l,s),f=a.get(h);f?f.push(u):a.set(h,[u])}for(let[u,h]of a)a.set(u,r(h,o));return t(a)})(e,0)}function $N(e,t){return Array.from(t,n=>e[n])}function ha(e,...t){if(typeof e[Symbol.iterator]!="function")throw new TypeError("values is not iterable");e=Array.from(e);let[n]=t;if(n&&n.length!==2||t.length>1){let i=Uint32Array.from(e,(r,s)=>s);return t.length>1?(t=t.map(r=>e.map(r)),i.sort((r,s)=>{for(let o of t){let a=lh(o[r],o[s]);if(a)return a}})):(n=e.map(n),i.sort((r,s)=>lh(n[r],n[s]))),$N(e,i)}return e.sort(b1(n))}function b1(e=gn){if(e===gn)return lh;if(typeof e!="function")throw new TypeError("compare is not a function");return(t,n)=>{let i=e(t,n);return i||i===0?i:(e(n,n)===0)-(e(t,t)===0)}}function lh(e,t){return(e==null||!(e>=e))-(t==null||!(t>=t))||(e<t?-1:e>t?1:0)}function fh(e,t,n){return(t.length!==2?ha(Br(e,t,n),(([i,r],[s,o])=>gn(r,o)||gn(i,s))):ha(to(e,n),(([i,r],[s,o])=>t(r,o)||gn(i,s)))).map(([i])=>i)}var XN=Array.prototype,vG=XN.slice;var qN=Math.sqrt(50),YN=Math.sqrt(10),ZN=Math.sqrt(2);function uh(e,t,n){let i=(t-e)/Math.max(0,n),r=Math.floor(Math.log10(i)),s=i/Math.pow(10,r),o=s>=qN?10:s>=YN?5:s>=ZN?2:1,a,c,l;return r<0?(l=Math.pow(10,-r)/o,a=Math.round(e*l),c=Math.round(t*l),a/l<e&&++a,c/l>t&&--c,l=-l):(l=Math.pow(10,r)*o,a=Math.round(e/l),c=Math.round(t/l),a*l<e&&++a,c*l>t&&--c),c<a&&.5<=n&&n<2?uh(e,t,n*2):[a,c,l]}function _s(e,t,n){if(t=+t,e=+e,n=+n,!(n>0))return[];if(e===t)return[e];let i=t<e,[r,s,o]=i?uh(t,e,n):uh(e,t,n);if(!(s>=r))return[];let a=s-r+1,c=new Array(a);if(i)if(o<0)for(let l=0;l<a;++l)c[l]=(s-l)/-o;else for(let l=0;l<a;++l)c[l]=(s-l)*o;else if(o<0)for(let l=0;l<a;++l)c[l]=(r+l)/-o;else for(let l=0;l<a;++l)c[l]=(r+l)*o;return c}function da(e,t,n){return t=+t,e=+e,n=+n,uh(e,t,n)[2]}function tl(e,t,n){t=+t,e=+e,n=+n;let i=t<e,r=i?da(t,e,n):da(e,t,n);return(i?-1:1)*(r<0?1/-r:r)}function M1(e){return Math.max(1,Math.ceil(Math.log(Xm(e))/Math.LN2)+1)}function An(e,t){let n;if(t===void 0)for(let i of e)i!=null&&(n<i||n===void 0&&i>=i)&&(n=i);else{let i=-1;for(let r of e)(r=t(r,++i,e))!=null&&(n<r||n===void 0&&r>=r)&&(n=r)}return n}function S1(e,t){let n,i=-1,r=-1;if(t===void 0)for(let s of e)++r,s!=null&&(n<s||n===void 0&&s>=s)&&(n=s,i=r);else for(let s of e)(s=t(s,++r,e))!=null&&(n<s||n===void 0&&s>=s)&&(n=s,i=r);return i}function ci(e,t){let n;if(t===void 0)for(let i of e)i!=null&&(n>i||n===void 0&&i>=i)&&(n=i);else{let i=-1;for(let r of e)(r=t(r,++i,e))!=null&&(n>r||n===void 0&&r>=r)&&(n=r)}return n}function w1(e,t){let n,i=-1,r=-1;if(t===void 0)for(let s of e)++r,s!=null&&(n>s||n===void 0&&s>=s)&&(n=s,i=r);else for(let s of e)(s=t(s,++r,e))!=null&&(n>s||n===void 0&&s>=s)&&(n=s,i=r);return i}function T1(e,t,n=0,i=1/0,r){if(t=Math.floor(t),n=Math.floor(Math.max(0,n)),i=Math.floor(Math.min(e.length-1,i)),!(n<=t&&t<=i))return e;for(r=r===void 0?lh:b1(r);i>n;){if(i-n>600){let c=i-n+1,l=t-n+1,u=Math.log(c),h=.5*Math.exp(2*u/3),f=.5*Math.sqrt(u*h*(c-h)/c)*(l-c/2<0?-1:1),d=Math.max(n,Math.floor(t-l*h/c+f)),p=Math.min(i,Math.floor(t+(c-l)*h/c+f));T1(e,t,d,p,r)}let s=e[t],o=n,a=i;for(Qc(e,n,t),r(e[i],s)>0&&Qc(e,n,i);o<a;){for(Qc(e,o,a),++o,--a;r(e[o],s)<0;)++o;for(;r(e[a],s)>0;)--a}r(e[n],s)===0?Qc(e,n,a):(++a,Qc(e,a,i)),a<=t&&(n=a+1),t<=a&&(i=a-1)}return e}function Qc(e,t,n){let i=e[t];e[t]=e[n],e[n]=i}function Jm(e,t=gn){let n,i=!1;if(t.length===1){let r;for(let s of e){let o=t(s);(i?gn(o,r)>0:gn(o,o)===0)&&(n=s,r=o,i=!0)}}else for(let r of e)(i?t(r,n)>0:t(r,r)===0)&&(n=r,i=!0);return n}function Ur(e,t,n){if(e=Float64Array.from(BN(e,n)),!(!(i=e.length)||isNaN(t=+t))){if(t<=0||i<2)return ci(e);if(t>=1)return An(e);var i,r=(i-1)*t,s=Math.floor(r),o=An(T1(e,s).subarray(0,s+1)),a=ci(e.subarray(s+1));return o+(a-o)*(r-s)}}function A1(e,t,n=f1){if(!(!(i=e.length)||isNaN(t=+t))){if(t<=0||i<2)return+n(e[0],0,e);if(t>=1)return+n(e[i-1],i-1,e);var i,r=(i-1)*t,s=Math.floor(r),o=+n(e[s],s,e),a=+n(e[s+1],s+1,e);return o+(a-o)*(r-s)}}function E1(e,t,n){let i=Xm(e),r=Ur(e,.75)-Ur(e,.25);return i&&r?Math.ceil((n-t)/(2*r*Math.pow(i,-1/3))):1}function Km(e,t,n){let i=Xm(e),r=Ym(e);return i&&r?Math.ceil((n-t)*Math.cbrt(i)/(3.49*r)):1}function C1(e,t){let n=0,i=0;if(t===void 0)for(let r of e)r!=null&&(r=+r)>=r&&(++n,i+=r);else{let r=-1;for(let s of e)(s=t(s,++r,e))!=null&&(s=+s)>=s&&(++n,i+=s)}if(n)return i/n}function el(e,t){return Ur(e,.5,t)}function*JN(e){for(let t of e)yield*t}function jm(e){return Array.from(JN(e))}function R1(e,t){let n=new ai;if(t===void 0)for(let s of e)s!=null&&s>=s&&n.set(s,(n.get(s)||0)+1);else{let s=-1;for(let o of e)(o=t(o,++s,e))!=null&&o>=o&&n.set(o,(n.get(o)||0)+1)}let i,r=0;for(let[s,o]of n)o>r&&(r=o,i=s);return i}function I1(e,t=KN){let n=[],i,r=!1;for(let s of e)r&&n.push(t(i,s)),i=s,r=!0;return n}function KN(e,t){return[e,t]}function ga(e,t,n){e=+e,t=+t,n=(r=arguments.length)<2?(t=e,e=0,1):r<3?1:+n;for(var i=-1,r=Math.max(0,Math.ceil((t-e)/n))|0,s=new Array(r);++i<r;)s[i]=e+i*n;return s}var bG=jN(Math.random);function jN(e){return function(n,i=0,r=n.length){let s=r-(i=+i);for(;s;){let o=e()*s--|0,a=n[s+i];n[s+i]=n[o+i],n[o+i]=a}return n}}function Li(e,t){let n=0;if(t===void 0)for(let i of e)(i=+i)&&(n+=i);else{let i=-1;for(let r of e)(r=+t(r,++i,e))&&(n+=r)}return n}function ya(e){if(typeof e[Symbol.iterator]!="function")throw new TypeError("values is not iterable");return Array.from(e).reverse()}function QN(e){return e}var Qm=1,tg=2,eg=3,hh=4,P1=1e-6;function tD(e){return"translate("+e+",0)"}function eD(e){return"translate(0,"+e+")"}function nD(e){return t=>+e(t)}function iD(e,t){return t=Math.max(0,e.bandwidth()-t*2)/2,e.round()&&(t=Math.round(t)),n=>+e(n)+t}function rD(){return!this.__axis}function sD(e,t){var n=[],i=null,r=null,s=6,o=6,a=3,c=typeof window<"u"&&window.devicePixelRatio>1?0:.5,l=e===Qm||e===hh?-1:1,u=e===hh||e===tg?"x":"y",h=e===Qm||e===eg?tD:eD;function f(d){var p=i??(t.ticks?t.ticks.apply(t,n):t.domain()),y=r??(t.tickFormat?t.tickFormat.apply(t,n):QN),m=Math.max(s,0)+a,g=t.range(),v=+g[0]+c,S=+g[g.length-1]+c,_=(t.bandwidth?iD:nD)(t.copy(),c),w=d.selection?d.selection():d,b=w.selectAll(".domain").data([null]),x=w.selectAll(".tick").data(p,t).order(),M=x.exit(),R=x.enter().append("g").attr("class","tick"),E=x.select("line"),C=x.select("text");b=b.merge(b.enter().insert("path",".tick").attr("class","domain").attr("stroke","currentColor")),x=x.merge(R),E=E.merge(R.append("line").attr("stroke","currentColor").attr(u+"2",l*s)),C=C.merge(R.append("text").attr("fill","currentColor").attr(u,l*m).attr("dy",e===Qm?"0em":e===eg?"0.71em":"0.32em")),d!==w&&(b=b.transition(d),x=x.transition(d),E=E.transition(d),C=C.transition(d),M=M.transition(d).attr("opacity",P1).attr("transform",function(N){return isFinite(N=_(N))?h(N+c):this.getAttribute("transform")}),R.attr("opacity",P1).attr("transform",function(N){var B=this.parentNode.__axis;return h((B&&isFinite(B=B(N))?B:_(N))+c)})),M.remove(),b.attr("d",e===hh||e===tg?o?"M"+l*o+","+v+"H"+c+"V"+S+"H"+l*o:"M"+c+","+v+"V"+S:o?"M"+v+","+l*o+"V"+c+"H"+S+"V"+l*o:"M"+v+","+c+"H"+S),x.attr("opacity",1).attr("transform",function(N){return h(_(N)+c)}),E.attr(u+"2",l*s),C.attr(u,l*m).text(y),w.filter(rD).attr("fill","none").attr("font-size",10).attr("font-family","sans-serif").attr("text-anchor",e===tg?"start":e===hh?"end":"middle"),w.each(function(){this.__axis=_})}return f.scale=function(d){return arguments.length?(t=d,f):t},f.ticks=function(){return n=Array.from(arguments),f},f.tickArguments=function(d){return arguments.length?(n=d==null?[]:Array.from(d),f):n.slice()},f.tickValues=function(d){return arguments.length?(i=d==null?null:Array.from(d),f):i&&i.slice()},f.tickFormat=function(d){return arguments.length?(r=d,f):r},f.tickSize=function(d){return arguments.length?(s=o=+d,f):s},f.tickSizeInner=function(d){return arguments.length?(s=+d,f):s},f.tickSizeOuter=function(d){return arguments.length?(o=+d,f):o},f.tickPadding=function(d){return arguments.length?(a=+d,f):a},f.offset=function(d){return arguments.length?(c=+d,f):c},f}function L1(e){return sD(eg,e)}var ng="http://www.w3.org/1999/xhtml",vs={svg:"http://www.w3.org/2000/svg",xhtml:ng,xlink:"http://www.w3.org/1999/xlink",xml:"http://www.w3.org/XML/1998/namespace",xmlns:"http://www.w3.org/2000/xmlns/"};function N1(e){var t=e+="",n=t.indexOf(":");return n>=0&&(t=e.slice(0,n))!=="xmlns"&&(e=e.slice(n+1)),vs.hasOwnProperty(t)?{space:vs[t],local:e}:e}function oD(e){return function(){var t=this.ownerDocument,n=this.namespaceURI;return n===ng&&t.documentElement.namespaceURI===ng?t.createElement(e):t.createElementNS(n,e)}}function aD(e){return function(){return this.ownerDocument.createElementNS(e.space,e.local)}}function xa(e){var t=N1(e);return(t.local?aD:oD)(t)}function cD(){}function D1(e){return e==null?cD:function(){return this.querySelector(e)}}function lD(e){typeof e!="function"&&(e=D1(e));for(var t=this._groups,n=t.length,i=new Array(n),r=0;r<n;++r)for(var s=t[r],o=s.length,a=i[r]=new Array(o),c,l,u=0;u<o;++u)(c=s[u])&&(l=e.call(c,c.__data__,u,s))&&("__data__"in c&&(l.__data__=c.__data__),a[u]=l);return new Jn(i,this._parents)}function uD(e){return e==null?[]:Array.isArray(e)?e:Array.from(e)}function fD(){return[]}function hD(e){return e==null?fD:function(){return this.querySelectorAll(e)}}function dD(e){return function(){return uD(e.apply(this,arguments))}}function pD(e){typeof e=="function"?e=dD(e):e=hD(e);for(var t=this._groups,n=t.length,i=[],r=[],s=0;s<n;++s)for(var o=t[s],a=o.length,c,l=0;l<a;++l)(c=o[l])&&(i.push(e.call(c,c.__data__,l,o)),r.push(c));return new Jn(i,r)}function mD(e){return function(){return this.matches(e)}}function F1(e){return function(t){return t.matches(e)}}var gD=Array.prototype.find;function yD(e){return function(){return gD.call(this.children,e)}}function xD(){return this.firstElementChild}function _D(e){return this.select(e==null?xD:yD(typeof e=="function"?e:F1(e)))}var vD=Array.prototype.filter;function bD(){return Array.from(this.children)}function MD(e){return function(){return vD.call(this.children,e)}}function SD(e){return this.selectAll(e==null?bD:MD(typeof e=="function"?e:F1(e)))}function wD(e){typeof e!="function"&&(e=mD(e));for(var t=this._groups,n=t.length,i=new Array(n),r=0;r<n;++r)for(var s=t[r],o=s.length,a=i[r]=[],c,l=0;l<o;++l)(c=s[l])&&e.call(c,c.__data__,l,s)&&a.push(c);return new Jn(i,this._parents)}function U1(e){return new Array(e.length)}function TD(){return new Jn(this._enter||this._groups.map(U1),this._parents)}function dh(e,t){this.ownerDocument=e.ownerDocument,this.namespaceURI=e.namespaceURI,this._next=null,this._parent=e,this.__data__=t}dh.prototype={constructor:dh,appendChild:function(e){return this._parent.insertBefore(e,this._next)},insertBefore:function(e,t){return this._parent.insertBefore(e,t)},querySelector:function(e){return this._parent.querySelector(e)},querySelectorAll:function(e){return this._parent.querySelectorAll(e)}};function AD(e){return function(){return e}}function ED(e,t,n,i,r,s){for(var o=0,a,c=t.length,l=s.length;o<l;++o)(a=t[o])?(a.__data__=s[o],i[o]=a):n[o]=new dh(e,s[o]);for(;o<c;++o)(a=t[o])&&(r[o]=a)}function CD(e,t,n,i,r,s,o){var a,c,l=new Map,u=t.length,h=s.length,f=new Array(u),d;for(a=0;a<u;++a)(c=t[a])&&(f[a]=d=o.call(c,c.__data__,a,t)+"",l.has(d)?r[a]=c:l.set(d,c));for(a=0;a<h;++a)d=o.call(e,s[a],a,s)+"",(c=l.get(d))?(i[a]=c,c.__data__=s[a],l.delete(d)):n[a]=new dh(e,s[a]);for(a=0;a<u;++a)(c=t[a])&&l.get(f[a])===c&&(r[a]=c)}function RD(e){return e.__data__}function ID(e,t){if(!arguments.length)return Array.from(this,RD);var n=t?CD:ED,i=this._parents,r=this._groups;typeof e!="function"&&(e=AD(e));for(var s=r.length,o=new Array(s),a=new Array(s),c=new Array(s),l=0;l<s;++l){var u=i[l],h=r[l],f=h.length,d=PD(e.call(u,u&&u.__data__,l,i)),p=d.length,y=a[l]=new Array(p),m=o[l]=new Array(p),g=c[l]=new Array(f);n(u,h,y,m,g,d,t);for(var v=0,S=0,_,w;v<p;++v)if(_=y[v]){for(v>=S&&(S=v+1);!(w=m[S])&&++S<p;);_._next=w||null}}return o=new Jn(o,i),o._enter=a,o._exit=c,o}function PD(e){return typeof e=="object"&&"length"in e?e:Array.from(e)}function LD(){return new Jn(this._exit||this._groups.map(U1),this._parents)}function ND(e,t,n){var i=this.enter(),r=this,s=this.exit();return typeof e=="function"?(i=e(i),i&&(i=i.selection())):i=i.append(e+""),t!=null&&(r=t(r),r&&(r=r.selection())),n==null?s.remove():n(s),i&&r?i.merge(r).order():r}function DD(e){for(var t=e.selection?e.selection():e,n=this._groups,i=t._groups,r=n.length,s=i.length,o=Math.min(r,s),a=new Array(r),c=0;c<o;++c)for(var l=n[c],u=i[c],h=l.length,f=a[c]=new Array(h),d,p=0;p<h;++p)(d=l[p]||u[p])&&(f[p]=d);for(;c<r;++c)a[c]=n[c];return new Jn(a,this._parents)}function FD(){for(var e=this._groups,t=-1,n=e.length;++t<n;)for(var i=e[t],r=i.length-1,s=i[r],o;--r>=0;)(o=i[r])&&(s&&o.compareDocumentPosition(s)^4&&s.parentNode.insertBefore(o,s),s=o);return this}function UD(e){e||(e=OD);function t(h,f){return h&&f?e(h.__data__,f.__data__):!h-!f}for(var n=this._groups,i=n.length,r=new Array(i),s=0;s<i;++s){for(var o=n[s],a=o.length,c=r[s]=new Array(a),l,u=0;u<a;++u)(l=o[u])&&(c[u]=l);c.sort(t)}return new Jn(r,this._parents).order()}function OD(e,t){return e<t?-1:e>t?1:e>=t?0:NaN}function BD(){var e=arguments[0];return arguments[0]=this,e.apply(null,arguments),this}function kD(){return Array.from(this)}function zD(){for(var e=this._groups,t=0,n=e.length;t<n;++t)for(var i=e[t],r=0,s=i.length;r<s;++r){var o=i[r];if(o)return o}return null}function GD(){let e=0;for(let t of this)++e;return e}function VD(){return!this.node()}function HD(e){for(var t=this._groups,n=0,i=t.length;n<i;++n)for(var r=t[n],s=0,o=r.length,a;s<o;++s)(a=r[s])&&e.call(a,a.__data__,s,r);return this}function WD(e){return function(){this.removeAttribute(e)}}function $D(e){return function(){this.removeAttributeNS(e.space,e.local)}}function XD(e,t){return function(){this.setAttribute(e,t)}}function qD(e,t){return function(){this.setAttributeNS(e.space,e.local,t)}}function YD(e,t){return function(){var n=t.apply(this,arguments);n==null?this.removeAttribute(e):this.setAttribute(e,n)}}function ZD(e,t){return function(){var n=t.apply(this,arguments);n==null?this.removeAttributeNS(e.space,e.local):this.setAttributeNS(e.space,e.local,n)}}function JD(e,t){var n=N1(e);if(arguments.length<2){var i=this.node();return n.local?i.getAttributeNS(n.space,n.local):i.getAttribute(n)}return this.each((t==null?n.local?$D:WD:typeof t=="function"?n.local?ZD:YD:n.local?qD:XD)(n,t))}function O1(e){return e.ownerDocument&&e.ownerDocument.defaultView||e.document&&e||e.defaultView}function KD(e){return function(){this.style.removeProperty(e)}}function jD(e,t,n){return function(){this.style.setProperty(e,t,n)}}function QD(e,t,n){return function(){var i=t.apply(this,arguments);i==null?this.style.removeProperty(e):this.style.setProperty(e,i,n)}}function tF(e,t,n){return arguments.length>1?this.each((t==null?KD:typeof t=="function"?QD:jD)(e,t,n??"")):eF(this.node(),e)}function eF(e,t){return e.style.getPropertyValue(t)||O1(e).getComputedStyle(e,null).getPropertyValue(t)}function nF(e){return function(){delete this[e]}}function iF(e,t){return function(){this[e]=t}}function rF(e,t){return function(){var n=t.apply(this,arguments);n==null?delete this[e]:this[e]=n}}function sF(e,t){return arguments.length>1?this.each((t==null?nF:typeof t=="function"?rF:iF)(e,t)):this.node()[e]}function B1(e){return e.trim().split(/^|\s+/)}function rg(e){return e.classList||new k1(e)}function k1(e){this._node=e,this._names=B1(e.getAttribute("class")||"")}k1.prototype={add:function(e){var t=this._names.indexOf(e);t<0&&(this._names.push(e),this._node.setAttribute("class",this._names.join(" ")))},remove:function(e){var t=this._names.indexOf(e);t>=0&&(this._names.splice(t,1),this._node.setAttribute("class",this._names.join(" ")))},contains:function(e){return this._names.indexOf(e)>=0}};function z1(e,t){for(var n=rg(e),i=-1,r=t.length;++i<r;)n.add(t[i])}function G1(e,t){for(var n=rg(e),i=-1,r=t.length;++i<r;)n.remove(t[i])}function oF(e){return function(){z1(this,e)}}function aF(e){return function(){G1(this,e)}}function cF(e,t){return function(){(t.apply(this,arguments)?z1:G1)(this,e)}}function lF(e,t){var n=B1(e+"");if(arguments.length<2){for(var i=rg(this.node()),r=-1,s=n.length;++r<s;)if(!i.contains(n[r]))return!1;return!0}return this.each((typeof t=="function"?cF:t?oF:aF)(n,t))}function uF(){this.textContent=""}function fF(e){return function(){this.textContent=e}}function hF(e){return function(){var t=e.apply(this,arguments);this.textContent=t??""}}function dF(e){return arguments.length?this.each(e==null?uF:(typeof e=="function"?hF:fF)(e)):this.node().textContent}function pF(){this.innerHTML=""}function mF(e){return function(){this.innerHTML=e}}function gF(e){return function(){var t=e.apply(this,arguments);this.innerHTML=t??""}}function yF(e){return arguments.length?this.each(e==null?pF:(typeof e=="function"?gF:mF)(e)):this.node().innerHTML}function xF(){this.nextSibling&&this.parentNode.appendChild(this)}function _F(){return this.each(xF)}function vF(){this.previousSibling&&this.parentNode.insertBefore(this,this.parentNode.firstChild)}function bF(){return this.each(vF)}function MF(e){var t=typeof e=="function"?e:xa(e);return this.select(function(){return this.appendChild(t.apply(this,arguments))})}function SF(){return null}function wF(e,t){var n=typeof e=="function"?e:xa(e),i=t==null?SF:typeof t=="function"?t:D1(t);return this.select(function(){return this.insertBefore(n.apply(this,arguments),i.apply(this,arguments)||null)})}function TF(){var e=this.parentNode;e&&e.removeChild(this)}function AF(){return this.each(TF)}function EF(){var e=this.cloneNode(!1),t=this.parentNode;return t?t.insertBefore(e,this.nextSibling):e}function CF(){var e=this.cloneNode(!0),t=this.parentNode;return t?t.insertBefore(e,this.nextSibling):e}function RF(e){return this.select(e?CF:EF)}function IF(e){return arguments.length?this.property("__data__",e):this.node().__data__}function PF(e){return function(t){e.call(this,t,this.__data__)}}function LF(e){return e.trim().split(/^|\s+/).map(function(t){var n="",i=t.indexOf(".");return i>=0&&(n=t.slice(i+1),t=t.slice(0,i)),{type:t,name:n}})}function NF(e){return function(){var t=this.__on;if(t){for(var n=0,i=-1,r=t.length,s;n<r;++n)s=t[n],(!e.type||s.type===e.type)&&s.name===e.name?this.removeEventListener(s.type,s.listener,s.options):t[++i]=s;++i?t.length=i:delete this.__on}}}function DF(e,t,n){return function(){var i=this.__on,r,s=PF(t);if(i){for(var o=0,a=i.length;o<a;++o)if((r=i[o]).type===e.type&&r.name===e.name){this.removeEventListener(r.type,r.listener,r.options),this.addEventListener(r.type,r.listener=s,r.options=n),r.value=t;return}}this.addEventListener(e.type,s,n),r={type:e.type,name:e.name,value:t,listener:s,options:n},i?i.push(r):this.__on=[r]}}function FF(e,t,n){var i=LF(e+""),r,s=i.length,o;if(arguments.length<2){var a=this.node().__on;if(a){for(var c=0,l=a.length,u;c<l;++c)for(r=0,u=a[c];r<s;++r)if((o=i[r]).type===u.type&&o.name===u.name)return u.value}return}for(a=t?DF:NF,r=0;r<s;++r)this.each(a(i[r],t,n));return this}function V1(e,t,n){var i=O1(e),r=i.CustomEvent;typeof r=="function"?r=new r(t,n):(r=i.document.createEvent("Event"),n?(r.initEvent(t,n.bubbles,n.cancelable),r.detail=n.detail):r.initEvent(t,!1,!1)),e.dispatchEvent(r)}function UF(e,t){return function(){return V1(this,e,t)}}function OF(e,t){return function(){return V1(this,e,t.apply(this,arguments))}}function BF(e,t){return this.each((typeof t=="function"?OF:UF)(e,t))}function*kF(){for(var e=this._groups,t=0,n=e.length;t<n;++t)for(var i=e[t],r=0,s=i.length,o;r<s;++r)(o=i[r])&&(yield o)}var H1=[null];function Jn(e,t){this._groups=e,this._parents=t}function zF(){return new Jn([[document.documentElement]],H1)}function GF(){return this}Jn.prototype=zF.prototype={constructor:Jn,select:lD,selectAll:pD,selectChild:_D,selectChildren:SD,filter:wD,data:ID,enter:TD,exit:LD,join:ND,merge:DD,selection:GF,order:FD,sort:UD,call:BD,nodes:kD,node:zD,size:GD,empty:VD,each:HD,attr:JD,style:tF,property:sF,classed:lF,text:dF,html:yF,raise:_F,lower:bF,append:MF,insert:wF,remove:AF,clone:RF,datum:IF,on:FF,dispatch:BF,[Symbol.iterator]:kF};function Ni(e){return typeof e=="string"?new Jn([[document.querySelector(e)]],[document.documentElement]):new Jn([[e]],H1)}var VF=0;function HF(){return new ig}function ig(){this._="@"+(++VF).toString(36)}ig.prototype=HF.prototype={constructor:ig,get:function(e){for(var t=this._;!(t in e);)if(!(e=e.parentNode))return;return e[t]},set:function(e,t){return e[this._]=t},remove:function(e){return this._ in e&&delete e[this._]},toString:function(){return this._}};function WF(e){let t;for(;t=e.sourceEvent;)e=t;return e}function W1(e,t){if(e=WF(e),t===void 0&&(t=e.currentTarget),t){var n=t.ownerSVGElement||t;if(n.createSVGPoint){var i=n.createSVGPoint();return i.x=e.clientX,i.y=e.clientY,i=i.matrixTransform(t.getScreenCTM().inverse()),[i.x,i.y]}if(t.getBoundingClientRect){var r=t.getBoundingClientRect();return[e.clientX-r.left-t.clientLeft,e.clientY-r.top-t.clientTop]}}return[e.pageX,e.pageY]}function Ma(e,t,n){e.prototype=t.prototype=n,n.constructor=e}function rl(e,t){var n=Object.create(e.prototype);for(var i in t)n[i]=t[i];return n}function bs(){}var ro=.7,ba=1/ro,_a="\\s*([+-]?\\d+)\\s*",nl="\\s*([+-]?(?:\\d*\\.)?\\d+(?:[eE][+-]?\\d+)?)\\s*",Qi="\\s*([+-]?(?:\\d*\\.)?\\d+(?:[eE][+-]?\\d+)?)%\\s*",$F=/^#([0-9a-f]{3,8})$/,XF=new RegExp(`^rgb\\(${_a},${_a},${_a}\\)$`),qF=new RegExp(`^rgb\\(${Qi},${Qi},${Qi}\\)$`),YF=new RegExp(`^rgba\\(${_a},${_a},${_a},${nl}\\)$`),ZF=new RegExp(`^rgba\\(${Qi},${Qi},${Qi},${nl}\\)$`),JF=new RegExp(`^hsl\\(${nl},${Qi},${Qi}\\)$`),KF=new RegExp(`^hsla\\(${nl},${Qi},${Qi},${nl}\\)$`),$1={aliceblue:15792383,antiquewhite:16444375,aqua:65535,aquamarine:8388564,azure:15794175,beige:16119260,bisque:16770244,black:0,blanchedalmond:16772045,blue:255,blueviolet:9055202,brown:10824234,burlywood:14596231,cadetblue:6266528,chartreuse:8388352,chocolate:13789470,coral:16744272,cornflowerblue:6591981,cornsilk:16775388,crimson:14423100,cyan:65535,darkblue:139,darkcyan:35723,darkgoldenrod:12092939,darkgray:11119017,darkgreen:25600,darkgrey:11119017,darkkhaki:12433259,darkmagenta:9109643,darkolivegreen:5597999,darkorange:16747520,darkorchid:10040012,darkred:9109504,darksalmon:15308410,darkseagreen:9419919,darkslateblue:4734347,darkslategray:3100495,darkslategrey:3100495,darkturquoise:52945,darkviolet:9699539,deeppink:16716947,deepskyblue:49151,dimgray:6908265,dimgrey:6908265,dodgerblue:2003199,firebrick:11674146,floralwhite:16775920,forestgreen:2263842,fuchsia:16711935,gainsboro:14474460,ghostwhite:16316671,gold:16766720,goldenrod:14329120,gray:8421504,green:32768,greenyellow:11403055,grey:8421504,honeydew:15794160,hotpink:16738740,indianred:13458524,indigo:4915330,ivory:16777200,khaki:15787660,lavender:15132410,lavenderblush:16773365,lawngreen:8190976,lemonchiffon:16775885,lightblue:11393254,lightcoral:15761536,lightcyan:14745599,lightgoldenrodyellow:16448210,lightgray:13882323,lightgreen:9498256,lightgrey:13882323,lightpink:16758465,lightsalmon:16752762,lightseagreen:2142890,lightskyblue:8900346,lightslategray:7833753,lightslategrey:7833753,lightsteelblue:11584734,lightyellow:16777184,lime:65280,limegreen:3329330,linen:16445670,magenta:16711935,maroon:8388608,mediumaquamarine:6737322,mediumblue:205,mediumorchid:12211667,mediumpurple:9662683,mediumseagreen:3978097,mediumslateblue:8087790,mediumspringgreen:64154,mediumturquoise:4772300,mediumvioletred:13047173,midnightblue:1644912,mintcream:16121850,mistyrose:16770273,moccasin:16770229,navajowhite:16768685,navy:128,oldlace:16643558,olive:8421376,olivedrab:7048739,orange:16753920,orangered:16729344,orchid:14315734,palegoldenrod:15657130,palegreen:10025880,paleturquoise:11529966,palevioletred:14381203,papayawhip:16773077,peachpuff:16767673,peru:13468991,pink:16761035,plum:14524637,powderblue:11591910,purple:8388736,rebeccapurple:6697881,red:16711680,rosybrown:12357519,royalblue:4286945,saddlebrown:9127187,salmon:16416882,sandybrown:16032864,seagreen:3050327,seashell:16774638,sienna:10506797,silver:12632256,skyblue:8900331,slateblue:6970061,slategray:7372944,slategrey:7372944,snow:16775930,springgreen:65407,steelblue:4620980,tan:13808780,teal:32896,thistle:14204888,tomato:16737095,turquoise:4251856,violet:15631086,wheat:16113331,white:16777215,whitesmoke:16119285,yellow:16776960,yellowgreen:10145074};Ma(bs,Sa,{copy(e){return Object.assign(new this.constructor,this,e)},displayable(){return this.rgb().displayable()},hex:X1,formatHex:X1,formatHex8:jF,formatHsl:QF,formatRgb:q1,toString:q1});function X1(){return this.rgb().formatHex()}function jF(){return this.rgb().formatHex8()}function QF(){return nM(this).formatHsl()}function q1(){return this.rgb().formatRgb()}function Sa(e){var t,n;return e=(e+"").trim().toLowerCase(),(t=$F.exec(e))?(n=t[1].length,t=parseInt(t[1],16),n===6?Y1(t):n===3?new Qe(t>>8&15|t>>4&240,t>>4&15|t&240,(t&15)<<4|t&15,1):n===8?ph(t>>24&255,t>>16&255,t>>8&255,(t&255)/255):n===4?ph(t>>12&15|t>>8&240,t>>8&15|t>>4&240,t>>4&15|t&240,((t&15)<<4|t&15)/255):null):(t=XF.exec(e))?new Qe(t[1],t[2],t[3],1):(t=qF.exec(e))?new Qe(t[1]*255/100,t[2]*255/100,t[3]*255/100,1):(t=YF.exec(e))?ph(t[1],t[2],t[3],t[4]):(t=ZF.exec(e))?ph(t[1]*255/100,t[2]*255/100,t[3]*255/100,t[4]):(t=JF.exec(e))?K1(t[1],t[2]/100,t[3]/100,1):(t=KF.exec(e))?K1(t[1],t[2]/100,t[3]/100,t[4]):$1.hasOwnProperty(e)?Y1($1[e]):e==="transparent"?new Qe(NaN,NaN,NaN,0):null}function Y1(e){return new Qe(e>>16&255,e>>8&255,e&255,1)}function ph(e,t,n,i){return i<=0&&(e=t=n=NaN),new Qe(e,t,n,i)}function ug(e){return e instanceof bs||(e=Sa(e)),e?(e=e.rgb(),new Qe(e.r,e.g,e.b,e.opacity)):new Qe}function Fi(e,t,n,i){return arguments.length===1?ug(e):new Qe(e,t,n,i??1)}function Qe(e,t,n,i){this.r=+e,this.g=+t,this.b=+n,this.opacity=+i}Ma(Qe,Fi,rl(bs,{brighter(e){return e=e==null?ba:Math.pow(ba,e),new Qe(this.r*e,this.g*e,this.b*e,this.opacity)},darker(e){return e=e==null?ro:Math.pow(ro,e),new Qe(this.r*e,this.g*e,this.b*e,this.opacity)},rgb(){return this},clamp(){return new Qe(no(this.r),no(this.g),no(this.b),gh(this.opacity))},displayable(){return-.5<=this.r&&this.r<255.5&&-.5<=this.g&&this.g<255.5&&-.5<=this.b&&this.b<255.5&&0<=this.opacity&&this.opacity<=1},hex:Z1,formatHex:Z1,formatHex8:tU,formatRgb:J1,toString:J1}));function Z1(){return`#${eo(this.r)}${eo(this.g)}${eo(this.b)}`}function tU(){return`#${eo(this.r)}${eo(this.g)}${eo(this.b)}${eo((isNaN(this.opacity)?1:this.opacity)*255)}`}function J1(){let e=gh(this.opacity);return`${e===1?"rgb(":"rgba("}${no(this.r)}, ${no(this.g)}, ${no(this.b)}${e===1?")":`, ${e})`}`}function gh(e){return isNaN(e)?1:Math.max(0,Math.min(1,e))}function no(e){return Math.max(0,Math.min(255,Math.round(e)||0))}function eo(e){return e=no(e),(e<16?"0":"")+e.toString(16)}function K1(e,t,n,i){return i<=0?e=t=n=NaN:n<=0||n>=1?e=t=NaN:t<=0&&(e=NaN),new Di(e,t,n,i)}function nM(e){if(e instanceof Di)return new Di(e.h,e.s,e.l,e.opacity);if(e instanceof bs||(e=Sa(e)),!e)return new Di;if(e instanceof Di)return e;e=e.rgb();var t=e.r/255,n=e.g/255,i=e.b/255,r=Math.min(t,n,i),s=Math.max(t,n,i),o=NaN,a=s-r,c=(s+r)/2;return a?(t===s?o=(n-i)/a+(n<i)*6:n===s?o=(i-t)/a+2:o=(t-n)/a+4,a/=c<.5?s+r:2-s-r,o*=60):a=c>0&&c<1?0:o,new Di(o,a,c,e.opacity)}function xh(e,t,n,i){return arguments.length===1?nM(e):new Di(e,t,n,i??1)}function Di(e,t,n,i){this.h=+e,this.s=+t,this.l=+n,this.opacity=+i}Ma(Di,xh,rl(bs,{brighter(e){return e=e==null?ba:Math.pow(ba,e),new Di(this.h,this.s,this.l*e,this.opacity)},darker(e){return e=e==null?ro:Math.pow(ro,e),new Di(this.h,this.s,this.l*e,this.opacity)},rgb(){var e=this.h%360+(this.h<0)*360,t=isNaN(e)||isNaN(this.s)?0:this.s,n=this.l,i=n+(n<.5?n:1-n)*t,r=2*n-i;return new Qe(sg(e>=240?e-240:e+120,r,i),sg(e,r,i),sg(e<120?e+240:e-120,r,i),this.opacity)},clamp(){return new Di(j1(this.h),mh(this.s),mh(this.l),gh(this.opacity))},displayable(){return(0<=this.s&&this.s<=1||isNaN(this.s))&&0<=this.l&&this.l<=1&&0<=this.opacity&&this.opacity<=1},formatHsl(){let e=gh(this.opacity);return`${e===1?"hsl(":"hsla("}${j1(this.h)}, ${mh(this.s)*100}%, ${mh(this.l)*100}%${e===1?")":`, ${e})`}`}}));function j1(e){return e=(e||0)%360,e<0?e+360:e}function mh(e){return Math.max(0,Math.min(1,e||0))}function sg(e,t,n){return(e<60?t+(n-t)*e/60:e<180?n:e<240?t+(n-t)*(240-e)/60:t)*255}var iM=Math.PI/180,rM=180/Math.PI,yh=18,sM=.96422,oM=1,aM=.82521,cM=4/29,va=6/29,lM=3*va*va,eU=va*va*va;function uM(e){if(e instanceof tr)return new tr(e.l,e.a,e.b,e.opacity);if(e instanceof kr)return fM(e);e instanceof Qe||(e=ug(e));var t=lg(e.r),n=lg(e.g),i=lg(e.b),r=og((.2225045*t+.7168786*n+.0606169*i)/oM),s,o;return t===n&&n===i?s=o=r:(s=og((.4360747*t+.3850649*n+.1430804*i)/sM),o=og((.0139322*t+.0971045*n+.7141733*i)/aM)),new tr(116*r-16,500*(s-r),200*(r-o),e.opacity)}function _h(e,t,n,i){return arguments.length===1?uM(e):new tr(e,t,n,i??1)}function tr(e,t,n,i){this.l=+e,this.a=+t,this.b=+n,this.opacity=+i}Ma(tr,_h,rl(bs,{brighter(e){return new tr(this.l+yh*(e??1),this.a,this.b,this.opacity)},darker(e){return new tr(this.l-yh*(e??1),this.a,this.b,this.opacity)},rgb(){var e=(this.l+16)/116,t=isNaN(this.a)?e:e+this.a/500,n=isNaN(this.b)?e:e-this.b/200;return t=sM*ag(t),e=oM*ag(e),n=aM*ag(n),new Qe(cg(3.1338561*t-1.6168667*e-.4906146*n),cg(-.9787684*t+1.9161415*e+.033454*n),cg(.0719453*t-.2289914*e+1.4052427*n),this.opacity)}}));function og(e){return e>eU?Math.pow(e,1/3):e/lM+cM}function ag(e){return e>va?e*e*e:lM*(e-cM)}function cg(e){return 255*(e<=.0031308?12.92*e:1.055*Math.pow(e,1/2.4)-.055)}function lg(e){return(e/=255)<=.04045?e/12.92:Math.pow((e+.055)/1.055,2.4)}function nU(e){if(e instanceof kr)return new kr(e.h,e.c,e.l,e.opacity);if(e instanceof tr||(e=uM(e)),e.a===0&&e.b===0)return new kr(NaN,0<e.l&&e.l<100?0:NaN,e.l,e.opacity);var t=Math.atan2(e.b,e.a)*rM;return new kr(t<0?t+360:t,Math.sqrt(e.a*e.a+e.b*e.b),e.l,e.opacity)}function vh(e,t,n,i){return arguments.length===1?nU(e):new kr(e,t,n,i??1)}function kr(e,t,n,i){this.h=+e,this.c=+t,this.l=+n,this.opacity=+i}function fM(e){if(isNaN(e.h))return new tr(e.l,0,0,e.opacity);var t=e.h*iM;return new tr(e.l,Math.cos(t)*e.c,Math.sin(t)*e.c,e.opacity)}Ma(kr,vh,rl(bs,{brighter(e){return new kr(this.h,this.c,this.l+yh*(e??1),this.opacity)},darker(e){return new kr(this.h,this.c,this.l-yh*(e??1),this.opacity)},rgb(){return fM(this).rgb()}}));var hM=-.14861,fg=1.78277,hg=-.29227,bh=-.90649,il=1.97294,Q1=il*bh,tM=il*fg,eM=fg*hg-bh*hM;function iU(e){if(e instanceof io)return new io(e.h,e.s,e.l,e.opacity);e instanceof Qe||(e=ug(e));var t=e.r/255,n=e.g/255,i=e.b/255,r=(eM*i+Q1*t-tM*n)/(eM+Q1-tM),s=i-r,o=(il*(n-r)-hg*s)/bh,a=Math.sqrt(o*o+s*s)/(il*r*(1-r)),c=a?Math.atan2(o,s)*rM-120:NaN;return new io(c<0?c+360:c,a,r,e.opacity)}function li(e,t,n,i){return arguments.length===1?iU(e):new io(e,t,n,i??1)}function io(e,t,n,i){this.h=+e,this.s=+t,this.l=+n,this.opacity=+i}Ma(io,li,rl(bs,{brighter(e){return e=e==null?ba:Math.pow(ba,e),new io(this.h,this.s,this.l*e,this.opacity)},darker(e){return e=e==null?ro:Math.pow(ro,e),new io(this.h,this.s,this.l*e,this.opacity)},rgb(){var e=isNaN(this.h)?0:(this.h+120)*iM,t=+this.l,n=isNaN(this.s)?0:this.s*t*(1-t),i=Math.cos(e),r=Math.sin(e);return new Qe(255*(t+n*(hM*i+fg*r)),255*(t+n*(hg*i+bh*r)),255*(t+n*(il*i)),this.opacity)}}));function mM(e,t,n,i,r){var s=e*e,o=s*e;return((1-3*e+3*s-o)*t+(4-6*s+3*o)*n+(1+3*e+3*s-3*o)*i+o*r)/6}function rU(e){var t=e.length-1;return function(n){var i=n<=0?n=0:n>=1?(n=1,t-1):Math.floor(n*t),r=e[i],s=e[i+1],o=i>0?e[i-1]:2*r-s,a=i<t-1?e[i+2]:2*s-r;return mM((n-i/t)*t,o,r,s,a)}}function sU(e){var t=e.length;return function(n){var i=Math.floor(((n%=1)<0?++n:n)*t),r=e[(i+t-1)%t],s=e[i%t],o=e[(i+1)%t],a=e[(i+2)%t];return mM((n-i/t)*t,r,s,o,a)}}var Sh=e=>()=>e;function gM(e,t){return function(n){return e+n*t}}function oU(e,t,n){return e=Math.pow(e,n),t=Math.pow(t,n)-e,n=1/n,function(i){return Math.pow(e+i*t,n)}}function gg(e,t){var n=t-e;return n?gM(e,n>180||n<-180?n-360*Math.round(n/360):n):Sh(isNaN(e)?t:e)}function aU(e){return(e=+e)==1?tn:function(t,n){return n-t?oU(t,n,e):Sh(isNaN(t)?n:t)}}function tn(e,t){var n=t-e;return n?gM(e,n):Sh(isNaN(e)?t:e)}var so=(function e(t){var n=aU(t);function i(r,s){var o=n((r=Fi(r)).r,(s=Fi(s)).r),a=n(r.g,s.g),c=n(r.b,s.b),l=tn(r.opacity,s.opacity);return function(u){return r.r=o(u),r.g=a(u),r.b=c(u),r.opacity=l(u),r+""}}return i.gamma=e,i})(1);function yM(e){return function(t){var n=t.length,i=new Array(n),r=new Array(n),s=new Array(n),o,a;for(o=0;o<n;++o)a=Fi(t[o]),i[o]=a.r||0,r[o]=a.g||0,s[o]=a.b||0;return i=e(i),r=e(r),s=e(s),a.opacity=1,function(c){return a.r=i(c),a.g=r(c),a.b=s(c),a+""}}}var xM=yM(rU),EG=yM(sU);function cU(e,t){t||(t=[]);var n=e?Math.min(t.length,e.length):0,i=t.slice(),r;return function(s){for(r=0;r<n;++r)i[r]=e[r]*(1-s)+t[r]*s;return i}}function lU(e){return ArrayBuffer.isView(e)&&!(e instanceof DataView)}function uU(e,t){var n=t?t.length:0,i=e?Math.min(n,e.length):0,r=new Array(i),s=new Array(n),o;for(o=0;o<i;++o)r[o]=wa(e[o],t[o]);for(;o<n;++o)s[o]=t[o];return function(a){for(o=0;o<i;++o)s[o]=r[o](a);return s}}function fU(e,t){var n=new Date;return e=+e,t=+t,function(i){return n.setTime(e*(1-i)+t*i),n}}function He(e,t){return e=+e,t=+t,function(n){return e*(1-n)+t*n}}function hU(e,t){var n={},i={},r;(e===null||typeof e!="object")&&(e={}),(t===null||typeof t!="object")&&(t={});for(r in t)r in e?n[r]=wa(e[r],t[r]):i[r]=t[r];return function(s){for(r in n)i[r]=n[r](s);return i}}var pg=/[-+]?(?:\d+\.?\d*|\.?\d+)(?:[eE][-+]?\d+)?/g,dg=new RegExp(pg.source,"g");function dU(e){return function(){return e}}function pU(e){return function(t){return e(t)+""}}function mU(e,t){var n=pg.lastIndex=dg.lastIndex=0,i,r,s,o=-1,a=[],c=[];for(e=e+"",t=t+"";(i=pg.exec(e))&&(r=dg.exec(t));)(s=r.index)>n&&(s=t.slice(n,s),a[o]?a[o]+=s:a[++o]=s),(i=i[0])===(r=r[0])?a[o]?a[o]+=r:a[++o]=r:(a[++o]=null,c.push({i:o,x:He(i,r)})),n=dg.lastIndex;return n<t.length&&(s=t.slice(n),a[o]?a[o]+=s:a[++o]=s),a.length<2?c[0]?pU(c[0].x):dU(t):(t=c.length,function(l){for(var u=0,h;u<t;++u)a[(h=c[u]).i]=h.x(l);return a.join("")})}function wa(e,t){var n=typeof t,i;return t==null||n==="boolean"?Sh(t):(n==="number"?He:n==="string"?(i=Sa(t))?(t=i,so):mU:t instanceof Sa?so:t instanceof Date?fU:lU(t)?cU:Array.isArray(t)?uU:typeof t.valueOf!="function"&&typeof t.toString!="function"||isNaN(t)?hU:He)(e,t)}function sl(e,t){return e=+e,t=+t,function(n){return Math.round(e*(1-n)+t*n)}}var dM=180/Math.PI,mg={translateX:0,translateY:0,rotate:0,skewX:0,scaleX:1,scaleY:1};function _M(e,t,n,i,r,s){var o,a,c;return(o=Math.sqrt(e*e+t*t))&&(e/=o,t/=o),(c=e*n+t*i)&&(n-=e*c,i-=t*c),(a=Math.sqrt(n*n+i*i))&&(n/=a,i/=a,c/=a),e*i<t*n&&(e=-e,t=-t,c=-c,o=-o),{translateX:r,translateY:s,rotate:Math.atan2(t,e)*dM,skewX:Math.atan(c)*dM,scaleX:o,scaleY:a}}var Mh;function gU(e){let t=new(typeof DOMMatrix=="function"?DOMMatrix:WebKitCSSMatrix)(e+"");return t.isIdentity?mg:_M(t.a,t.b,t.c,t.d,t.e,t.f)}function yU(e){return e==null||(Mh||(Mh=document.createElementNS("http://www.w3.org/2000/svg","g")),Mh.setAttribute("transform",e),!(e=Mh.transform.baseVal.consolidate()))?mg:(e=e.matrix,_M(e.a,e.b,e.c,e.d,e.e,e.f))}function vM(e,t,n,i){function r(l){return l.length?l.pop()+" ":""}function s(l,u,h,f,d,p){if(l!==h||u!==f){var y=d.push("translate(",null,t,null,n);p.push({i:y-4,x:He(l,h)},{i:y-2,x:He(u,f)})}else(h||f)&&d.push("translate("+h+t+f+n)}function o(l,u,h,f){l!==u?(l-u>180?u+=360:u-l>180&&(l+=360),f.push({i:h.push(r(h)+"rotate(",null,i)-2,x:He(l,u)})):u&&h.push(r(h)+"rotate("+u+i)}function a(l,u,h,f){l!==u?f.push({i:h.push(r(h)+"skewX(",null,i)-2,x:He(l,u)}):u&&h.push(r(h)+"skewX("+u+i)}function c(l,u,h,f,d,p){if(l!==h||u!==f){var y=d.push(r(d)+"scale(",null,",",null,")");p.push({i:y-4,x:He(l,h)},{i:y-2,x:He(u,f)})}else(h!==1||f!==1)&&d.push(r(d)+"scale("+h+","+f+")")}return function(l,u){var h=[],f=[];return l=e(l),u=e(u),s(l.translateX,l.translateY,u.translateX,u.translateY,h,f),o(l.rotate,u.rotate,h,f),a(l.skewX,u.skewX,h,f),c(l.scaleX,l.scaleY,u.scaleX,u.scaleY,h,f),l=u=null,function(d){for(var p=-1,y=f.length,m;++p<y;)h[(m=f[p]).i]=m.x(d);return h.join("")}}}var CG=vM(gU,"px, ","px)","deg)"),RG=vM(yU,", ",")",")"),xU=1e-12;function pM(e){return((e=Math.exp(e))+1/e)/2}function _U(e){return((e=Math.exp(e))-1/e)/2}function vU(e){return((e=Math.exp(2*e))-1)/(e+1)}var IG=(function e(t,n,i){function r(s,o){var a=s[0],c=s[1],l=s[2],u=o[0],h=o[1],f=o[2],d=u-a,p=h-c,y=d*d+p*p,m,g;if(y<xU)g=Math.log(f/l)/t,m=function(x){return[a+x*d,c+x*p,l*Math.exp(t*x*g)]};else{var v=Math.sqrt(y),S=(f*f-l*l+i*y)/(2*l*n*v),_=(f*f-l*l-i*y)/(2*f*n*v),w=Math.log(Math.sqrt(S*S+1)-S),b=Math.log(Math.sqrt(_*_+1)-_);g=(b-w)/t,m=function(x){var M=x*g,R=pM(w),E=l/(n*v)*(R*vU(t*M+w)-_U(w));return[a+E*d,c+E*p,l*R/pM(t*M+w)]}}return m.duration=Math.abs(g)*1e3*t/Math.SQRT2,m}return r.rho=function(s){var o=Math.max(.001,+s),a=o*o,c=a*a;return e(o,a,c)},r})(Math.SQRT2,2,4);function bM(e){return function(t,n){var i=e((t=xh(t)).h,(n=xh(n)).h),r=tn(t.s,n.s),s=tn(t.l,n.l),o=tn(t.opacity,n.opacity);return function(a){return t.h=i(a),t.s=r(a),t.l=s(a),t.opacity=o(a),t+""}}}var MM=bM(gg),PG=bM(tn);function SM(e,t){var n=tn((e=_h(e)).l,(t=_h(t)).l),i=tn(e.a,t.a),r=tn(e.b,t.b),s=tn(e.opacity,t.opacity);return function(o){return e.l=n(o),e.a=i(o),e.b=r(o),e.opacity=s(o),e+""}}function wM(e){return function(t,n){var i=e((t=vh(t)).h,(n=vh(n)).h),r=tn(t.c,n.c),s=tn(t.l,n.l),o=tn(t.opacity,n.opacity);return function(a){return t.h=i(a),t.c=r(a),t.l=s(a),t.opacity=o(a),t+""}}}var TM=wM(gg),LG=wM(tn);function AM(e){return(function t(n){n=+n;function i(r,s){var o=e((r=li(r)).h,(s=li(s)).h),a=tn(r.s,s.s),c=tn(r.l,s.l),l=tn(r.opacity,s.opacity);return function(u){return r.h=o(u),r.s=a(u),r.l=c(Math.pow(u,n)),r.opacity=l(u),r+""}}return i.gamma=t,i})(1)}var NG=AM(gg),wh=AM(tn);function Ms(e,t){t===void 0&&(t=e,e=wa);for(var n=0,i=t.length-1,r=t[0],s=new Array(i<0?0:i);n<i;)s[n]=e(r,r=t[++n]);return function(o){var a=Math.max(0,Math.min(i-1,Math.floor(o*=i)));return s[a](o-a)}}function En(e,t){for(var n=new Array(t),i=0;i<t;++i)n[i]=e(i/(t-1));return n}var ol=Math.PI,yg=2*ol,oo=1e-6,bU=yg-oo;function EM(e){this._+=e[0];for(let t=1,n=e.length;t<n;++t)this._+=arguments[t]+e[t]}function MU(e){let t=Math.floor(e);if(!(t>=0))throw new Error(`invalid digits: ${e}`);if(t>15)return EM;let n=10**t;return function(i){this._+=i[0];for(let r=1,s=i.length;r<s;++r)this._+=Math.round(arguments[r]*n)/n+i[r]}}function CM(e,t,n,i){return e===n&&t===i}function SU(e){let t=Math.floor(e);if(!(t<=15))return CM;let n=10**t,i=function(r){return Math.round(r*n)};return function(r,s,o,a){return i(r)===i(o)&&i(s)===i(a)}}var ao=class{constructor(t){this._x0=this._y0=this._x1=this._y1=null,this._="",this._append=t==null?EM:MU(t),this._equal=t==null?CM:SU(t)}moveTo(t,n){this._append`M${this._x0=this._x1=+t},${this._y0=this._y1=+n}`}closePath(){this._x1!==null&&(this._x1=this._x0,this._y1=this._y0,this._append`Z`)}lineTo(t,n){this._append`L${this._x1=+t},${this._y1=+n}`}quadraticCurveTo(t,n,i,r){this._append`Q${+t},${+n},${this._x1=+i},${this._y1=+r}`}bezierCurveTo(t,n,i,r,s,o){this._append`C${+t},${+n},${+i},${+r},${this._x1=+s},${this._y1=+o}`}arcTo(t,n,i,r,s){if(t=+t,n=+n,i=+i,r=+r,s=+s,s<0)throw new Error(`negative radius: ${s}`);let o=this._x1,a=this._y1,c=i-t,l=r-n,u=o-t,h=a-n,f=u*u+h*h;if(this._x1===null)this._append`M${this._x1=t},${this._y1=n}`;else if(f>oo)if(!(Math.abs(h*c-l*u)>oo)||!s)this._append`L${this._x1=t},${this._y1=n}`;else{let d=i-o,p=r-a,y=c*c+l*l,m=d*d+p*p,g=Math.sqrt(y),v=Math.sqrt(f),S=s*Math.tan((ol-Math.acos((y+f-m)/(2*g*v)))/2),_=S/v,w=S/g;Math.abs(_-1)>oo&&this._append`L${t+_*u},${n+_*h}`,this._append`A${s},${s},0,0,${+(h*d>u*p)},${this._x1=t+w*c},${this._y1=n+w*l}`}}arc(t,n,i,r,s,o){if(t=+t,n=+n,i=+i,o=!!o,i<0)throw new Error(`negative radius: ${i}`);let a=i*Math.cos(r),c=i*Math.sin(r),l=t+a,u=n+c,h=1^o,f=o?r-s:s-r;if(this._x1===null?this._append`M${l},${u}`:(Math.abs(this._x1-l)>oo||Math.abs(this._y1-u)>oo)&&this._append`L${l},${u}`,!!i){if(f<0&&(f=f%yg+yg),f>bU)this._append`A${i},${i},0,1,${h},${t-a},${n-c}A${i},${i},0,1,${h},${this._x1=l},${this._y1=u}`;else if(f>oo){let d=t+i*Math.cos(s),p=n+i*Math.sin(s);if(f>=ol&&this._equal(l,u,d,p)){f/=2;let y=r+f;this._append`A${i},${i},0,${+(f>=ol)},${h},${t+i*Math.cos(y)},${n+i*Math.sin(y)}`}this._append`A${i},${i},0,${+(f>=ol)},${h},${this._x1=d},${this._y1=p}`}}}rect(t,n,i,r){this._append`M${this._x0=this._x1=+t},${this._y0=this._y1=+n}h${i=+i}v${+r}h${-i}Z`}toString(){return this._}};function wU(){return new ao}wU.prototype=ao.prototype;function er(e=3){return new ao(+e)}function TU(e){return Math.abs(e=Math.round(e))>=1e21?e.toLocaleString("en").replace(/,/g,""):e.toString(10)}function Ah(e,t){if(!isFinite(e)||e===0)return null;var n=(e=t?e.toExponential(t-1):e.toExponential()).indexOf("e"),i=e.slice(0,n);return[i.length>1?i[0]+i.slice(2):i,+e.slice(n+1)]}function Ta(e){return e=Ah(Math.abs(e)),e?e[1]:NaN}function AU(e,t){return function(n,i){for(var r=n.length,s=[],o=0,a=e[0],c=0;r>0&&a>0&&(c+a+1>i&&(a=Math.max(1,i-c)),s.push(n.substring(r-=a,r+a)),!((c+=a+1)>i));)a=e[o=(o+1)%e.length];return s.reverse().join(t)}}function EU(e){return function(t){return t.replace(/[0-9]/g,function(n){return e[+n]})}}var CU=/^(?:(.)?([<>=^]))?([+\-( ])?([$#])?(0)?(\d+)?(,)?(\.\d+)?(~)?([a-z%])?$/i;function Aa(e){if(!(t=CU.exec(e)))throw new Error("invalid format: "+e);var t;return new xg({fill:t[1],align:t[2],sign:t[3],symbol:t[4],zero:t[5],width:t[6],comma:t[7],precision:t[8]&&t[8].slice(1),trim:t[9],type:t[10]})}Aa.prototype=xg.prototype;function xg(e){this.fill=e.fill===void 0?" ":e.fill+"",this.align=e.align===void 0?">":e.align+"",this.sign=e.sign===void 0?"-":e.sign+"",this.symbol=e.symbol===void 0?"":e.symbol+"",this.zero=!!e.zero,this.width=e.width===void 0?void 0:+e.width,this.comma=!!e.comma,this.precision=e.precision===void 0?void 0:+e.precision,this.trim=!!e.trim,this.type=e.type===void 0?"":e.type+""}xg.prototype.toString=function(){return this.fill+this.align+this.sign+this.symbol+(this.zero?"0":"")+(this.width===void 0?"":Math.max(1,this.width|0))+(this.comma?",":"")+(this.precision===void 0?"":"."+Math.max(0,this.precision|0))+(this.trim?"~":"")+this.type};function RU(e){t:for(var t=e.length,n=1,i=-1,r;n<t;++n)switch(e[n]){case".":i=r=n;break;case"0":i===0&&(i=n),r=n;break;default:if(!+e[n])break t;i>0&&(i=0);break}return i>0?e.slice(0,i)+e.slice(r+1):e}var Eh;function IU(e,t){var n=Ah(e,t);if(!n)return Eh=void 0,e.toPrecision(t);var i=n[0],r=n[1],s=r-(Eh=Math.max(-8,Math.min(8,Math.floor(r/3)))*3)+1,o=i.length;return s===o?i:s>o?i+new Array(s-o+1).join("0"):s>0?i.slice(0,s)+"."+i.slice(s):"0."+new Array(1-s).join("0")+Ah(e,Math.max(0,t+s-1))[0]}function RM(e,t){var n=Ah(e,t);if(!n)return e+"";var i=n[0],r=n[1];return r<0?"0."+new Array(-r).join("0")+i:i.length>r+1?i.slice(0,r+1)+"."+i.slice(r+1):i+new Array(r-i.length+2).join("0")}var IM={"%":(e,t)=>(e*100).toFixed(t),b:e=>Math.round(e).toString(2),c:e=>e+"",d:TU,e:(e,t)=>e.toExponential(t),f:(e,t)=>e.toFixed(t),g:(e,t)=>e.toPrecision(t),o:e=>Math.round(e).toString(8),p:(e,t)=>RM(e*100,t),r:RM,s:IU,X:e=>Math.round(e).toString(16).toUpperCase(),x:e=>Math.round(e).toString(16)};function PM(e){return e}var LM=Array.prototype.map,NM=["y","z","a","f","p","n","µ","m","","k","M","G","T","P","E","Z","Y"];function PU(e){var t=e.grouping===void 0||e.thousands===void 0?PM:AU(LM.call(e.grouping,Number),e.thousands+""),n=e.currency===void 0?"":e.currency[0]+"",i=e.currency===void 0?"":e.currency[1]+"",r=e.decimal===void 0?".":e.decimal+"",s=e.numerals===void 0?PM:EU(LM.call(e.numerals,String)),o=e.percent===void 0?"%":e.percent+"",a=e.minus===void 0?"−":e.minus+"",c=e.nan===void 0?"NaN":e.nan+"";function l(h,f){h=Aa(h);var d=h.fill,p=h.align,y=h.sign,m=h.symbol,g=h.zero,v=h.width,S=h.comma,_=h.precision,w=h.trim,b=h.type;b==="n"?(S=!0,b="g"):IM[b]||(_===void 0&&(_=12),w=!0,b="g"),(g||d==="0"&&p==="=")&&(g=!0,d="0",p="=");var x=(f&&f.prefix!==void 0?f.prefix:"")+(m==="$"?n:m==="#"&&/[boxX]/.test(b)?"0"+b.toLowerCase():""),M=(m==="$"?i:/[%p]/.test(b)?o:"")+(f&&f.suffix!==void 0?f.suffix:""),R=IM[b],E=/[defgprs%]/.test(b);_=_===void 0?6:/[gprs]/.test(b)?Math.max(1,Math.min(21,_)):Math.max(0,Math.min(20,_));function C(N){var B=x,I=M,L,k,F;if(b==="c")I=R(N)+I,N="";else{N=+N;var Z=N<0||1/N<0;if(N=isNaN(N)?c:R(Math.abs(N),_),w&&(N=RU(N)),Z&&+N==0&&y!=="+"&&(Z=!1),B=(Z?y==="("?y:a:y==="-"||y==="("?"":y)+B,I=(b==="s"&&!isNaN(N)&&Eh!==void 0?NM[8+Eh/3]:"")+I+(Z&&y==="("?")":""),E){for(L=-1,k=N.length;++L<k;)if(F=N.charCodeAt(L),48>F||F>57){I=(F===46?r+N.slice(L+1):N.slice(L))+I,N=N.slice(0,L);break}}}S&&!g&&(N=t(N,1/0));var U=B.length+N.length+I.length,G=U<v?new Array(v-U+1).join(d):"";switch(S&&g&&(N=t(G+N,G.length?v-I.length:1/0),G=""),p){case"<":N=B+N+I+G;break;case"=":N=B+G+N+I;break;case"^":N=G.slice(0,U=G.length>>1)+B+N+I+G.slice(U);break;default:N=G+B+N+I;break}return s(N)}return C.toString=function(){return h+""},C}function u(h,f){var d=Math.max(-8,Math.min(8,Math.floor(Ta(f)/3)))*3,p=Math.pow(10,-d),y=l((h=Aa(h),h.type="f",h),{suffix:NM[8+d/3]});return function(m){return y(p*m)}}return{format:l,formatPrefix:u}}var Th,nr,_g;LU({thousands:",",grouping:[3],currency:["$",""]});function LU(e){return Th=PU(e),nr=Th.format,_g=Th.formatPrefix,Th}function DM(e){return Math.max(0,-Ta(Math.abs(e)))}function FM(e,t){return Math.max(0,Math.max(-8,Math.min(8,Math.floor(Ta(t)/3)))*3-Ta(Math.abs(e)))}function UM(e,t){return e=Math.abs(e),t=Math.abs(t)-e,Math.max(0,Ta(t)-Ta(e))+1}var Wt=1e-6,eS=1e-12,jt=Math.PI,Ie=jt/2,OM=jt/4,Kn=jt*2,Cn=180/jt,Re=jt/180,fe=Math.abs,Ia=Math.atan,Gr=Math.atan2,Kt=Math.cos;var nS=Math.exp;var Dh=Math.log,vg=Math.pow,$t=Math.sin,fi=Math.sign||function(e){return e>0?1:e<0?-1:0},Bn=Math.sqrt,zg=Math.tan;function iS(e){return e>1?0:e<-1?jt:Math.acos(e)}function di(e){return e>1?Ie:e<-1?-Ie:Math.asin(e)}function hi(){}function Fh(e,t){e&&kM.hasOwnProperty(e.type)&&kM[e.type](e,t)}var BM={Feature:function(e,t){Fh(e.geometry,t)},FeatureCollection:function(e,t){for(var n=e.features,i=-1,r=n.length;++i<r;)Fh(n[i].geometry,t)}},kM={Sphere:function(e,t){t.sphere()},Point:function(e,t){e=e.coordinates,t.point(e[0],e[1],e[2])},MultiPoint:function(e,t){for(var n=e.coordinates,i=-1,r=n.length;++i<r;)e=n[i],t.point(e[0],e[1],e[2])},LineString:function(e,t){Tg(e.coordinates,t,0)},MultiLineString:function(e,t){for(var n=e.coordinates,i=-1,r=n.length;++i<r;)Tg(n[i],t,0)},Polygon:function(e,t){zM(e.coordinates,t)},MultiPolygon:function(e,t){for(var n=e.coordinates,i=-1,r=n.length;++i<r;)zM(n[i],t)},GeometryCollection:function(e,t){for(var n=e.geometries,i=-1,r=n.length;++i<r;)Fh(n[i],t)}};function Tg(e,t,n){var i=-1,r=e.length-n,s;for(t.lineStart();++i<r;)s=e[i],t.point(s[0],s[1],s[2]);t.lineEnd()}function zM(e,t){var n=-1,i=e.length;for(t.polygonStart();++n<i;)Tg(e[n],t,1);t.polygonEnd()}function Ss(e,t){e&&BM.hasOwnProperty(e.type)?BM[e.type](e,t):Fh(e,t)}var BG=new oi,kG=new oi;function Ag(e){return[Gr(e[1],e[0]),di(e[2])]}function Ca(e){var t=e[0],n=e[1],i=Kt(n);return[i*Kt(t),i*$t(t),$t(n)]}function Ch(e,t){return e[0]*t[0]+e[1]*t[1]+e[2]*t[2]}function Uh(e,t){return[e[1]*t[2]-e[2]*t[1],e[2]*t[0]-e[0]*t[2],e[0]*t[1]-e[1]*t[0]]}function bg(e,t){e[0]+=t[0],e[1]+=t[1],e[2]+=t[2]}function Rh(e,t){return[e[0]*t,e[1]*t,e[2]*t]}function Eg(e){var t=Bn(e[0]*e[0]+e[1]*e[1]+e[2]*e[2]);e[0]/=t,e[1]/=t,e[2]/=t}function Cg(e,t){function n(i,r){return i=e(i,r),t(i[0],i[1])}return e.invert&&t.invert&&(n.invert=function(i,r){return i=t.invert(i,r),i&&e.invert(i[0],i[1])}),n}function Rg(e,t){return fe(e)>jt&&(e-=Math.round(e/Kn)*Kn),[e,t]}Rg.invert=Rg;function rS(e,t,n){return(e%=Kn)?t||n?Cg(VM(e),HM(t,n)):VM(e):t||n?HM(t,n):Rg}function GM(e){return function(t,n){return t+=e,fe(t)>jt&&(t-=Math.round(t/Kn)*Kn),[t,n]}}function VM(e){var t=GM(e);return t.invert=GM(-e),t}function HM(e,t){var n=Kt(e),i=$t(e),r=Kt(t),s=$t(t);function o(a,c){var l=Kt(c),u=Kt(a)*l,h=$t(a)*l,f=$t(c),d=f*n+u*i;return[Gr(h*r-d*s,u*n-f*i),di(d*r+h*s)]}return o.invert=function(a,c){var l=Kt(c),u=Kt(a)*l,h=$t(a)*l,f=$t(c),d=f*r-h*s;return[Gr(h*r+f*s,u*n+d*i),di(d*n-u*i)]},o}function NU(e){e=rS(e[0]*Re,e[1]*Re,e.length>2?e[2]*Re:0);function t(n){return n=e(n[0]*Re,n[1]*Re),n[0]*=Cn,n[1]*=Cn,n}return t.invert=function(n){return n=e.invert(n[0]*Re,n[1]*Re),n[0]*=Cn,n[1]*=Cn,n},t}function DU(e,t,n,i,r,s){if(n){var o=Kt(t),a=$t(t),c=i*n;r==null?(r=t+i*Kn,s=t-c/2):(r=WM(o,r),s=WM(o,s),(i>0?r<s:r>s)&&(r+=i*Kn));for(var l,u=r;i>0?u>s:u<s;u-=c)l=Ag([o,-a*Kt(u),-a*$t(u)]),e.point(l[0],l[1])}}function WM(e,t){t=Ca(t),t[0]-=e,Eg(t);var n=iS(-t[1]);return((-t[2]<0?-n:n)+Kn-Wt)%Kn}function sS(){var e=[],t;return{point:function(n,i,r){t.push([n,i,r])},lineStart:function(){e.push(t=[])},lineEnd:hi,rejoin:function(){e.length>1&&e.push(e.pop().concat(e.shift()))},result:function(){var n=e;return e=[],t=null,n}}}function Nh(e,t){return fe(e[0]-t[0])<Wt&&fe(e[1]-t[1])<Wt}function Ih(e,t,n,i){this.x=e,this.z=t,this.o=n,this.e=i,this.v=!1,this.n=this.p=null}function oS(e,t,n,i,r){var s=[],o=[],a,c;if(e.forEach(function(p){if(!((y=p.length-1)<=0)){var y,m=p[0],g=p[y],v;if(Nh(m,g)){if(!m[2]&&!g[2]){for(r.lineStart(),a=0;a<y;++a)r.point((m=p[a])[0],m[1]);r.lineEnd();return}g[0]+=2*Wt}s.push(v=new Ih(m,p,null,!0)),o.push(v.o=new Ih(m,null,v,!1)),s.push(v=new Ih(g,p,null,!1)),o.push(v.o=new Ih(g,null,v,!0))}}),!!s.length){for(o.sort(t),$M(s),$M(o),a=0,c=o.length;a<c;++a)o[a].e=n=!n;for(var l=s[0],u,h;;){for(var f=l,d=!0;f.v;)if((f=f.n)===l)return;u=f.z,r.lineStart();do{if(f.v=f.o.v=!0,f.e){if(d)for(a=0,c=u.length;a<c;++a)r.point((h=u[a])[0],h[1]);else i(f.x,f.n.x,1,r);f=f.n}else{if(d)for(u=f.p.z,a=u.length-1;a>=0;--a)r.point((h=u[a])[0],h[1]);else i(f.x,f.p.x,-1,r);f=f.p}f=f.o,u=f.z,d=!d}while(!f.v);r.lineEnd()}}}function $M(e){if(t=e.length){for(var t,n=0,i=e[0],r;++n<t;)i.n=r=e[n],r.p=i,i=r;i.n=r=e[0],r.p=i}}function Mg(e){return fe(e[0])<=jt?e[0]:fi(e[0])*((fe(e[0])+jt)%Kn-jt)}function FU(e,t){var n=Mg(t),i=t[1],r=$t(i),s=[$t(n),-Kt(n),0],o=0,a=0,c=new oi;r===1?i=Ie+Wt:r===-1&&(i=-Ie-Wt);for(var l=0,u=e.length;l<u;++l)if(f=(h=e[l]).length)for(var h,f,d=h[f-1],p=Mg(d),y=d[1]/2+OM,m=$t(y),g=Kt(y),v=0;v<f;++v,p=_,m=b,g=x,d=S){var S=h[v],_=Mg(S),w=S[1]/2+OM,b=$t(w),x=Kt(w),M=_-p,R=M>=0?1:-1,E=R*M,C=E>jt,N=m*b;if(c.add(Gr(N*R*$t(E),g*x+N*Kt(E))),o+=C?M+R*Kn:M,C^p>=n^_>=n){var B=Uh(Ca(d),Ca(S));Eg(B);var I=Uh(s,B);Eg(I);var L=(C^M>=0?-1:1)*di(I[2]);(i>L||i===L&&(B[0]||B[1]))&&(a+=C^M>=0?1:-1)}}return(o<-Wt||o<Wt&&c<-eS)^a&1}function aS(e,t,n,i){return function(r){var s=t(r),o=sS(),a=t(o),c=!1,l,u,h,f={point:d,lineStart:y,lineEnd:m,polygonStart:function(){f.point=g,f.lineStart=v,f.lineEnd=S,u=[],l=[]},polygonEnd:function(){f.point=d,f.lineStart=y,f.lineEnd=m,u=jm(u);var _=FU(l,i);u.length?(c||(r.polygonStart(),c=!0),oS(u,OU,_,n,r)):_&&(c||(r.polygonStart(),c=!0),r.lineStart(),n(null,null,1,r),r.lineEnd()),c&&(r.polygonEnd(),c=!1),u=l=null},sphere:function(){r.polygonStart(),r.lineStart(),n(null,null,1,r),r.lineEnd(),r.polygonEnd()}};function d(_,w){e(_,w)&&r.point(_,w)}function p(_,w){s.point(_,w)}function y(){f.point=p,s.lineStart()}function m(){f.point=d,s.lineEnd()}function g(_,w){h.push([_,w]),a.point(_,w)}function v(){a.lineStart(),h=[]}function S(){g(h[0][0],h[0][1]),a.lineEnd();var _=a.clean(),w=o.result(),b,x=w.length,M,R,E;if(h.pop(),l.push(h),h=null,!!x){if(_&1){if(R=w[0],(M=R.length-1)>0){for(c||(r.polygonStart(),c=!0),r.lineStart(),b=0;b<M;++b)r.point((E=R[b])[0],E[1]);r.lineEnd()}return}x>1&&_&2&&w.push(w.pop().concat(w.shift())),u.push(w.filter(UU))}}return f}}function UU(e){return e.length>1}function OU(e,t){return((e=e.x)[0]<0?e[1]-Ie-Wt:Ie-e[1])-((t=t.x)[0]<0?t[1]-Ie-Wt:Ie-t[1])}var XM=aS(function(){return!0},BU,zU,[-jt,-Ie]);function BU(e){var t=NaN,n=NaN,i=NaN,r;return{lineStart:function(){e.lineStart(),r=1},point:function(s,o){var a=s>0?jt:-jt,c=fe(s-t);fe(c-jt)<Wt?(e.point(t,n=(n+o)/2>0?Ie:-Ie),e.point(i,n),e.lineEnd(),e.lineStart(),e.point(a,n),e.point(s,n),r=0):i!==a&&c>=jt&&(fe(t-i)<Wt&&(t-=i*Wt),fe(s-a)<Wt&&(s-=a*Wt),n=kU(t,n,s,o),e.point(i,n),e.lineEnd(),e.lineStart(),e.point(a,n),r=0),e.point(t=s,n=o),i=a},lineEnd:function(){e.lineEnd(),t=n=NaN},clean:function(){return 2-r}}}function kU(e,t,n,i){var r,s,o=$t(e-n);return fe(o)>Wt?Ia(($t(t)*(s=Kt(i))*$t(n)-$t(i)*(r=Kt(t))*$t(e))/(r*s*o)):(t+i)/2}function zU(e,t,n,i){var r;if(e==null)r=n*Ie,i.point(-jt,r),i.point(0,r),i.point(jt,r),i.point(jt,0),i.point(jt,-r),i.point(0,-r),i.point(-jt,-r),i.point(-jt,0),i.point(-jt,r);else if(fe(e[0]-t[0])>Wt){var s=e[0]<t[0]?jt:-jt;r=n*s/2,i.point(-s,r),i.point(0,r),i.point(s,r)}else i.point(t[0],t[1])}function GU(e){var t=Kt(e),n=2*Re,i=t>0,r=fe(t)>Wt;function s(u,h,f,d){DU(d,e,n,f,u,h)}function o(u,h){return Kt(u)*Kt(h)>t}function a(u){var h,f,d,p,y;return{lineStart:function(){p=d=!1,y=1},point:function(m,g){var v=[m,g],S,_=o(m,g),w=i?_?0:l(m,g):_?l(m+(m<0?jt:-jt),g):0;if(!h&&(p=d=_)&&u.lineStart(),_!==d&&(S=c(h,v),(!S||Nh(h,S)||Nh(v,S))&&(v[2]=1)),_!==d)y=0,_?(u.lineStart(),S=c(v,h),u.point(S[0],S[1])):(S=c(h,v),u.point(S[0],S[1],2),u.lineEnd()),h=S;else if(r&&h&&i^_){var b;!(w&f)&&(b=c(v,h,!0))&&(y=0,i?(u.lineStart(),u.point(b[0][0],b[0][1]),u.point(b[1][0],b[1][1]),u.lineEnd()):(u.point(b[1][0],b[1][1]),u.lineEnd(),u.lineStart(),u.point(b[0][0],b[0][1],3)))}_&&(!h||!Nh(h,v))&&u.point(v[0],v[1]),h=v,d=_,f=w},lineEnd:function(){d&&u.lineEnd(),h=null},clean:function(){return y|(p&&d)<<1}}}function c(u,h,f){var d=Ca(u),p=Ca(h),y=[1,0,0],m=Uh(d,p),g=Ch(m,m),v=m[0],S=g-v*v;if(!S)return!f&&u;var _=t*g/S,w=-t*v/S,b=Uh(y,m),x=Rh(y,_),M=Rh(m,w);bg(x,M);var R=b,E=Ch(x,R),C=Ch(R,R),N=E*E-C*(Ch(x,x)-1);if(!(N<0)){var B=Bn(N),I=Rh(R,(-E-B)/C);if(bg(I,x),I=Ag(I),!f)return I;var L=u[0],k=h[0],F=u[1],Z=h[1],U;k<L&&(U=L,L=k,k=U);var G=k-L,q=fe(G-jt)<Wt,st=q||G<Wt;if(!q&&Z<F&&(U=F,F=Z,Z=U),st?q?F+Z>0^I[1]<(fe(I[0]-L)<Wt?F:Z):F<=I[1]&&I[1]<=Z:G>jt^(L<=I[0]&&I[0]<=k)){var ct=Rh(R,(-E+B)/C);return bg(ct,x),[I,Ag(ct)]}}}function l(u,h){var f=i?e:jt-e,d=0;return u<-f?d|=1:u>f&&(d|=2),h<-f?d|=4:h>f&&(d|=8),d}return aS(o,a,s,i?[0,-e]:[-jt,e-jt])}function VU(e,t,n,i,r,s){var o=e[0],a=e[1],c=t[0],l=t[1],u=0,h=1,f=c-o,d=l-a,p;if(p=n-o,!(!f&&p>0)){if(p/=f,f<0){if(p<u)return;p<h&&(h=p)}else if(f>0){if(p>h)return;p>u&&(u=p)}if(p=r-o,!(!f&&p<0)){if(p/=f,f<0){if(p>h)return;p>u&&(u=p)}else if(f>0){if(p<u)return;p<h&&(h=p)}if(p=i-a,!(!d&&p>0)){if(p/=d,d<0){if(p<u)return;p<h&&(h=p)}else if(d>0){if(p>h)return;p>u&&(u=p)}if(p=s-a,!(!d&&p<0)){if(p/=d,d<0){if(p>h)return;p>u&&(u=p)}else if(d>0){if(p<u)return;p<h&&(h=p)}return u>0&&(e[0]=o+u*f,e[1]=a+u*d),h<1&&(t[0]=o+h*f,t[1]=a+h*d),!0}}}}}var al=1e9,Ph=-al;function Gg(e,t,n,i){function r(l,u){return e<=l&&l<=n&&t<=u&&u<=i}function s(l,u,h,f){var d=0,p=0;if(l==null||(d=o(l,h))!==(p=o(u,h))||c(l,u)<0^h>0)do f.point(d===0||d===3?e:n,d>1?i:t);while((d=(d+h+4)%4)!==p);else f.point(u[0],u[1])}function o(l,u){return fe(l[0]-e)<Wt?u>0?0:3:fe(l[0]-n)<Wt?u>0?2:1:fe(l[1]-t)<Wt?u>0?1:0:u>0?3:2}function a(l,u){return c(l.x,u.x)}function c(l,u){var h=o(l,1),f=o(u,1);return h!==f?h-f:h===0?u[1]-l[1]:h===1?l[0]-u[0]:h===2?l[1]-u[1]:u[0]-l[0]}return function(l){var u=l,h=sS(),f,d,p,y,m,g,v,S,_,w,b,x={point:M,lineStart:N,lineEnd:B,polygonStart:E,polygonEnd:C};function M(L,k){r(L,k)&&u.point(L,k)}function R(){for(var L=0,k=0,F=d.length;k<F;++k)for(var Z=d[k],U=1,G=Z.length,q=Z[0],st,ct,$=q[0],at=q[1];U<G;++U)st=$,ct=at,q=Z[U],$=q[0],at=q[1],ct<=i?at>i&&($-st)*(i-ct)>(at-ct)*(e-st)&&++L:at<=i&&($-st)*(i-ct)<(at-ct)*(e-st)&&--L;return L}function E(){u=h,f=[],d=[],b=!0}function C(){var L=R(),k=b&&L,F=(f=jm(f)).length;(k||F)&&(l.polygonStart(),k&&(l.lineStart(),s(null,null,1,l),l.lineEnd()),F&&oS(f,a,L,s,l),l.polygonEnd()),u=l,f=d=p=null}function N(){x.point=I,d&&d.push(p=[]),w=!0,_=!1,v=S=NaN}function B(){f&&(I(y,m),g&&_&&h.rejoin(),f.push(h.result())),x.point=M,_&&u.lineEnd()}function I(L,k){var F=r(L,k);if(d&&p.push([L,k]),w)y=L,m=k,g=F,w=!1,F&&(u.lineStart(),u.point(L,k));else if(F&&_)u.point(L,k);else{var Z=[v=Math.max(Ph,Math.min(al,v)),S=Math.max(Ph,Math.min(al,S))],U=[L=Math.max(Ph,Math.min(al,L)),k=Math.max(Ph,Math.min(al,k))];VU(Z,U,e,t,n,i)?(_||(u.lineStart(),u.point(Z[0],Z[1])),u.point(U[0],U[1]),F||u.lineEnd(),b=!1):F&&(u.lineStart(),u.point(L,k),b=!1)}v=L,S=k,_=F}return x}}var Ig=e=>e,Sg=new oi,Pg=new oi,cS,lS,Lg,Ng,zr={point:hi,lineStart:hi,lineEnd:hi,polygonStart:function(){zr.lineStart=HU,zr.lineEnd=$U},polygonEnd:function(){zr.lineStart=zr.lineEnd=zr.point=hi,Sg.add(fe(Pg)),Pg=new oi},result:function(){var e=Sg/2;return Sg=new oi,e}};function HU(){zr.point=WU}function WU(e,t){zr.point=uS,cS=Lg=e,lS=Ng=t}function uS(e,t){Pg.add(Ng*e-Lg*t),Lg=e,Ng=t}function $U(){uS(cS,lS)}var Ra=1/0,Oh=Ra,gl=-Ra,Bh=gl,kh={point:XU,lineStart:hi,lineEnd:hi,polygonStart:hi,polygonEnd:hi,result:function(){var e=[[Ra,Oh],[gl,Bh]];return gl=Bh=-(Oh=Ra=1/0),e}};function XU(e,t){e<Ra&&(Ra=e),e>gl&&(gl=e),t<Oh&&(Oh=t),t>Bh&&(Bh=t)}var Dg=0,Fg=0,cl=0,zh=0,Gh=0,Ea=0,Ug=0,Og=0,ll=0,fS,hS,ir,rr,ui={point:co,lineStart:qM,lineEnd:YM,polygonStart:function(){ui.lineStart=ZU,ui.lineEnd=JU},polygonEnd:function(){ui.point=co,ui.lineStart=qM,ui.lineEnd=YM},result:function(){var e=ll?[Ug/ll,Og/ll]:Ea?[zh/Ea,Gh/Ea]:cl?[Dg/cl,Fg/cl]:[NaN,NaN];return Dg=Fg=cl=zh=Gh=Ea=Ug=Og=ll=0,e}};function co(e,t){Dg+=e,Fg+=t,++cl}function qM(){ui.point=qU}function qU(e,t){ui.point=YU,co(ir=e,rr=t)}function YU(e,t){var n=e-ir,i=t-rr,r=Bn(n*n+i*i);zh+=r*(ir+e)/2,Gh+=r*(rr+t)/2,Ea+=r,co(ir=e,rr=t)}function YM(){ui.point=co}function ZU(){ui.point=KU}function JU(){dS(fS,hS)}function KU(e,t){ui.point=dS,co(fS=ir=e,hS=rr=t)}function dS(e,t){var n=e-ir,i=t-rr,r=Bn(n*n+i*i);zh+=r*(ir+e)/2,Gh+=r*(rr+t)/2,Ea+=r,r=rr*e-ir*t,Ug+=r*(ir+e),Og+=r*(rr+t),ll+=r*3,co(ir=e,rr=t)}function pS(e){this._context=e}pS.prototype={_radius:4.5,pointRadius:function(e){return this._radius=e,this},polygonStart:function(){this._line=0},polygonEnd:function(){this._line=NaN},lineStart:function(){this._point=0},lineEnd:function(){this._line===0&&this._context.closePath(),this._point=NaN},point:function(e,t){switch(this._point){case 0:{this._context.moveTo(e,t),this._point=1;break}case 1:{this._context.lineTo(e,t);break}default:{this._context.moveTo(e+this._radius,t),this._context.arc(e,t,this._radius,0,Kn);break}}},result:hi};var Bg=new oi,wg,mS,gS,ul,fl,yl={point:hi,lineStart:function(){yl.point=jU},lineEnd:function(){wg&&yS(mS,gS),yl.point=hi},polygonStart:function(){wg=!0},polygonEnd:function(){wg=null},result:function(){var e=+Bg;return Bg=new oi,e}};function jU(e,t){yl.point=yS,mS=ul=e,gS=fl=t}function yS(e,t){ul-=e,fl-=t,Bg.add(Bn(ul*ul+fl*fl)),ul=e,fl=t}var ZM,Vh,JM,KM,Hh=class{constructor(t){this._append=t==null?xS:QU(t),this._radius=4.5,this._=""}pointRadius(t){return this._radius=+t,this}polygonStart(){this._line=0}polygonEnd(){this._line=NaN}lineStart(){this._point=0}lineEnd(){this._line===0&&(this._+="Z"),this._point=NaN}point(t,n){switch(this._point){case 0:{this._append`M${t},${n}`,this._point=1;break}case 1:{this._append`L${t},${n}`;break}default:{if(this._append`M${t},${n}`,this._radius!==JM||this._append!==Vh){let i=this._radius,r=this._;this._="",this._append`m0,${i}a${i},${i} 0 1,1 0,${-2*i}a${i},${i} 0 1,1 0,${2*i}z`,JM=i,Vh=this._append,KM=this._,this._=r}this._+=KM;break}}}result(){let t=this._;return this._="",t.length?t:null}};function xS(e){let t=1;this._+=e[0];for(let n=e.length;t<n;++t)this._+=arguments[t]+e[t]}function QU(e){let t=Math.floor(e);if(!(t>=0))throw new RangeError(`invalid digits: ${e}`);if(t>15)return xS;if(t!==ZM){let n=10**t;ZM=t,Vh=function(r){let s=1;this._+=r[0];for(let o=r.length;s<o;++s)this._+=Math.round(arguments[s]*n)/n+r[s]}}return Vh}function _l(e,t){let n=3,i=4.5,r,s;function o(a){return a&&(typeof i=="function"&&s.pointRadius(+i.apply(this,arguments)),Ss(a,r(s))),s.result()}return o.area=function(a){return Ss(a,r(zr)),zr.result()},o.measure=function(a){return Ss(a,r(yl)),yl.result()},o.bounds=function(a){return Ss(a,r(kh)),kh.result()},o.centroid=function(a){return Ss(a,r(ui)),ui.result()},o.projection=function(a){return arguments.length?(r=a==null?(e=null,Ig):(e=a).stream,o):e},o.context=function(a){return arguments.length?(s=a==null?(t=null,new Hh(n)):new pS(t=a),typeof i!="function"&&s.pointRadius(i),o):t},o.pointRadius=function(a){return arguments.length?(i=typeof a=="function"?a:(s.pointRadius(+a),+a),o):i},o.digits=function(a){if(!arguments.length)return n;if(a==null)n=null;else{let c=Math.floor(a);if(!(c>=0))throw new RangeError(`invalid digits: ${a}`);n=c}return t===null&&(s=new Hh(n)),o},o.projection(e).digits(n).context(t)}function vl(e){return{stream:Xh(e)}}function Xh(e){return function(t){var n=new kg;for(var i in e)n[i]=e[i];return n.stream=t,n}}function kg(){}kg.prototype={constructor:kg,point:function(e,t){this.stream.point(e,t)},sphere:function(){this.stream.sphere()},lineStart:function(){this.stream.lineStart()},lineEnd:function(){this.stream.lineEnd()},polygonStart:function(){this.stream.polygonStart()},polygonEnd:function(){this.stream.polygonEnd()}};function Vg(e,t,n){var i=e.clipExtent&&e.clipExtent();return e.scale(150).translate([0,0]),i!=null&&e.clipExtent(null),Ss(n,e.stream(kh)),t(kh.result()),i!=null&&e.clipExtent(i),e}function Hg(e,t,n){return Vg(e,function(i){var r=t[1][0]-t[0][0],s=t[1][1]-t[0][1],o=Math.min(r/(i[1][0]-i[0][0]),s/(i[1][1]-i[0][1])),a=+t[0][0]+(r-o*(i[1][0]+i[0][0]))/2,c=+t[0][1]+(s-o*(i[1][1]+i[0][1]))/2;e.scale(150*o).translate([a,c])},n)}function _S(e,t,n){return Hg(e,[[0,0],t],n)}function vS(e,t,n){return Vg(e,function(i){var r=+t,s=r/(i[1][0]-i[0][0]),o=(r-s*(i[1][0]+i[0][0]))/2,a=-s*i[0][1];e.scale(150*s).translate([o,a])},n)}function bS(e,t,n){return Vg(e,function(i){var r=+t,s=r/(i[1][1]-i[0][1]),o=-s*i[0][0],a=(r-s*(i[1][1]+i[0][1]))/2;e.scale(150*s).translate([o,a])},n)}var jM=16,tO=Kt(30*Re);function QM(e,t){return+t?nO(e,t):eO(e)}function eO(e){return Xh({point:function(t,n){t=e(t,n),this.stream.point(t[0],t[1])}})}function nO(e,t){function n(i,r,s,o,a,c,l,u,h,f,d,p,y,m){var g=l-i,v=u-r,S=g*g+v*v;if(S>4*t&&y--){var _=o+f,w=a+d,b=c+p,x=Bn(_*_+w*w+b*b),M=di(b/=x),R=fe(fe(b)-1)<Wt||fe(s-h)<Wt?(s+h)/2:Gr(w,_),E=e(R,M),C=E[0],N=E[1],B=C-i,I=N-r,L=v*B-g*I;(L*L/S>t||fe((g*B+v*I)/S-.5)>.3||o*f+a*d+c*p<tO)&&(n(i,r,s,o,a,c,C,N,R,_/=x,w/=x,b,y,m),m.point(C,N),n(C,N,R,_,w,b,l,u,h,f,d,p,y,m))}}return function(i){var r,s,o,a,c,l,u,h,f,d,p,y,m={point:g,lineStart:v,lineEnd:_,polygonStart:function(){i.polygonStart(),m.lineStart=w},polygonEnd:function(){i.polygonEnd(),m.lineStart=v}};function g(M,R){M=e(M,R),i.point(M[0],M[1])}function v(){h=NaN,m.point=S,i.lineStart()}function S(M,R){var E=Ca([M,R]),C=e(M,R);n(h,f,u,d,p,y,h=C[0],f=C[1],u=M,d=E[0],p=E[1],y=E[2],jM,i),i.point(h,f)}function _(){m.point=g,i.lineEnd()}function w(){v(),m.point=b,m.lineEnd=x}function b(M,R){S(r=M,R),s=h,o=f,a=d,c=p,l=y,m.point=S}function x(){n(h,f,u,d,p,y,s,o,r,a,c,l,jM,i),m.lineEnd=_,_()}return m}}var iO=Xh({point:function(e,t){this.stream.point(e*Re,t*Re)}});function rO(e){return Xh({point:function(t,n){var i=e(t,n);return this.stream.point(i[0],i[1])}})}function sO(e,t,n,i,r){function s(o,a){return o*=i,a*=r,[t+e*o,n-e*a]}return s.invert=function(o,a){return[(o-t)/e*i,(n-a)/e*r]},s}function tS(e,t,n,i,r,s){if(!s)return sO(e,t,n,i,r);var o=Kt(s),a=$t(s),c=o*e,l=a*e,u=o/e,h=a/e,f=(a*n-o*t)/e,d=(a*t+o*n)/e;function p(y,m){return y*=i,m*=r,[c*y-l*m+t,n-l*y-c*m]}return p.invert=function(y,m){return[i*(u*y-h*m+f),r*(d-h*y-u*m)]},p}function ws(e){return MS(function(){return e})()}function MS(e){var t,n=150,i=480,r=250,s=0,o=0,a=0,c=0,l=0,u,h=0,f=1,d=1,p=null,y=XM,m=null,g,v,S,_=Ig,w=.5,b,x,M,R,E;function C(L){return M(L[0]*Re,L[1]*Re)}function N(L){return L=M.invert(L[0],L[1]),L&&[L[0]*Cn,L[1]*Cn]}C.stream=function(L){return R&&E===L?R:R=iO(rO(u)(y(b(_(E=L)))))},C.preclip=function(L){return arguments.length?(y=L,p=void 0,I()):y},C.postclip=function(L){return arguments.length?(_=L,m=g=v=S=null,I()):_},C.clipAngle=function(L){return arguments.length?(y=+L?GU(p=L*Re):(p=null,XM),I()):p*Cn},C.clipExtent=function(L){return arguments.length?(_=L==null?(m=g=v=S=null,Ig):Gg(m=+L[0][0],g=+L[0][1],v=+L[1][0],S=+L[1][1]),I()):m==null?null:[[m,g],[v,S]]},C.scale=function(L){return arguments.length?(n=+L,B()):n},C.translate=function(L){return arguments.length?(i=+L[0],r=+L[1],B()):[i,r]},C.center=function(L){return arguments.length?(s=L[0]%360*Re,o=L[1]%360*Re,B()):[s*Cn,o*Cn]},C.rotate=function(L){return arguments.length?(a=L[0]%360*Re,c=L[1]%360*Re,l=L.length>2?L[2]%360*Re:0,B()):[a*Cn,c*Cn,l*Cn]},C.angle=function(L){return arguments.length?(h=L%360*Re,B()):h*Cn},C.reflectX=function(L){return arguments.length?(f=L?-1:1,B()):f<0},C.reflectY=function(L){return arguments.length?(d=L?-1:1,B()):d<0},C.precision=function(L){return arguments.length?(b=QM(x,w=L*L),I()):Bn(w)},C.fitExtent=function(L,k){return Hg(C,L,k)},C.fitSize=function(L,k){return _S(C,L,k)},C.fitWidth=function(L,k){return vS(C,L,k)},C.fitHeight=function(L,k){return bS(C,L,k)};function B(){var L=tS(n,0,0,f,d,h).apply(null,t(s,o)),k=tS(n,i-L[0],r-L[1],f,d,h);return u=rS(a,c,l),x=Cg(t,k),M=Cg(u,x),b=QM(x,w),I()}function I(){return R=E=null,C}return function(){return t=e.apply(this,arguments),C.invert=t.invert&&N,B()}}function Wg(e){var t=0,n=jt/3,i=MS(e),r=i(t,n);return r.parallels=function(s){return arguments.length?i(t=s[0]*Re,n=s[1]*Re):[t*Cn,n*Cn]},r}function oO(e){var t=Kt(e);function n(i,r){return[i*t,$t(r)/t]}return n.invert=function(i,r){return[i/t,di(r*t)]},n}function aO(e,t){var n=$t(e),i=(n+$t(t))/2;if(fe(i)<Wt)return oO(e);var r=1+n*(2*i-n),s=Bn(r)/i;function o(a,c){var l=Bn(r-2*i*$t(c))/i;return[l*$t(a*=i),s-l*Kt(a)]}return o.invert=function(a,c){var l=s-c,u=Gr(a,fe(l))*fi(l);return l*i<0&&(u-=jt*fi(a)*fi(l)),[u/i,di((r-(a*a+l*l)*i*i)/(2*i))]},o}function xl(){return Wg(aO).scale(155.424).center([0,33.6442])}function $g(){return xl().parallels([29.5,45.5]).scale(1070).translate([480,250]).rotate([96,0]).center([-.6,38.7])}function cO(e){var t=e.length;return{point:function(n,i){for(var r=-1;++r<t;)e[r].point(n,i)},sphere:function(){for(var n=-1;++n<t;)e[n].sphere()},lineStart:function(){for(var n=-1;++n<t;)e[n].lineStart()},lineEnd:function(){for(var n=-1;++n<t;)e[n].lineEnd()},polygonStart:function(){for(var n=-1;++n<t;)e[n].polygonStart()},polygonEnd:function(){for(var n=-1;++n<t;)e[n].polygonEnd()}}}function SS(){var e,t,n=$g(),i,r=xl().rotate([154,0]).center([-2,58.5]).parallels([55,65]),s,o=xl().rotate([157,0]).center([-3,19.9]).parallels([8,18]),a,c,l={point:function(f,d){c=[f,d]}};function u(f){var d=f[0],p=f[1];return c=null,i.point(d,p),c||(s.point(d,p),c)||(a.point(d,p),c)}u.invert=function(f){var d=n.scale(),p=n.translate(),y=(f[0]-p[0])/d,m=(f[1]-p[1])/d;return(m>=.12&&m<.234&&y>=-.425&&y<-.214?r:m>=.166&&m<.234&&y>=-.214&&y<-.115?o:n).invert(f)},u.stream=function(f){return e&&t===f?e:e=cO([n.stream(t=f),r.stream(f),o.stream(f)])},u.precision=function(f){return arguments.length?(n.precision(f),r.precision(f),o.precision(f),h()):n.precision()},u.scale=function(f){return arguments.length?(n.scale(f),r.scale(f*.35),o.scale(f),u.translate(n.translate())):n.scale()},u.translate=function(f){if(!arguments.length)return n.translate();var d=n.scale(),p=+f[0],y=+f[1];return i=n.translate(f).clipExtent([[p-.455*d,y-.238*d],[p+.455*d,y+.238*d]]).stream(l),s=r.translate([p-.307*d,y+.201*d]).clipExtent([[p-.425*d+Wt,y+.12*d+Wt],[p-.214*d-Wt,y+.234*d-Wt]]).stream(l),a=o.translate([p-.205*d,y+.212*d]).clipExtent([[p-.214*d+Wt,y+.166*d+Wt],[p-.115*d-Wt,y+.234*d-Wt]]).stream(l),h()},u.fitExtent=function(f,d){return Hg(u,f,d)},u.fitSize=function(f,d){return _S(u,f,d)},u.fitWidth=function(f,d){return vS(u,f,d)},u.fitHeight=function(f,d){return bS(u,f,d)};function h(){return e=t=null,u}return u.scale(1070)}function wS(e){return function(t,n){var i=Kt(t),r=Kt(n),s=e(i*r);return s===1/0?[2,0]:[s*r*$t(t),s*$t(n)]}}function bl(e){return function(t,n){var i=Bn(t*t+n*n),r=e(i),s=$t(r),o=Kt(r);return[Gr(t*s,i*o),di(i&&n*s/i)]}}var TS=wS(function(e){return Bn(2/(1+e))});TS.invert=bl(function(e){return 2*di(e/2)});function AS(){return ws(TS).scale(124.75).clipAngle(180-.001)}var ES=wS(function(e){return(e=iS(e))&&e/$t(e)});ES.invert=bl(function(e){return e});function CS(){return ws(ES).scale(79.4188).clipAngle(180-.001)}function qh(e,t){return[e,Dh(zg((Ie+t)/2))]}qh.invert=function(e,t){return[e,2*Ia(nS(t))-Ie]};function RS(){return IS(qh).scale(961/Kn)}function IS(e){var t=ws(e),n=t.center,i=t.scale,r=t.translate,s=t.clipExtent,o=null,a,c,l;t.scale=function(h){return arguments.length?(i(h),u()):i()},t.translate=function(h){return arguments.length?(r(h),u()):r()},t.center=function(h){return arguments.length?(n(h),u()):n()},t.clipExtent=function(h){return arguments.length?(h==null?o=a=c=l=null:(o=+h[0][0],a=+h[0][1],c=+h[1][0],l=+h[1][1]),u()):o==null?null:[[o,a],[c,l]]};function u(){var h=jt*i(),f=t(NU(t.rotate()).invert([0,0]));return s(o==null?[[f[0]-h,f[1]-h],[f[0]+h,f[1]+h]]:e===qh?[[Math.max(f[0]-h,o),a],[Math.min(f[0]+h,c),l]]:[[o,Math.max(f[1]-h,a)],[c,Math.min(f[1]+h,l)]])}return u()}function Lh(e){return zg((Ie+e)/2)}function lO(e,t){var n=Kt(e),i=e===t?$t(e):Dh(n/Kt(t))/Dh(Lh(t)/Lh(e)),r=n*vg(Lh(e),i)/i;if(!i)return qh;function s(o,a){r>0?a<-Ie+Wt&&(a=-Ie+Wt):a>Ie-Wt&&(a=Ie-Wt);var c=r/vg(Lh(a),i);return[c*$t(i*o),r-c*Kt(i*o)]}return s.invert=function(o,a){var c=r-a,l=fi(i)*Bn(o*o+c*c),u=Gr(o,fe(c))*fi(c);return c*i<0&&(u-=jt*fi(o)*fi(c)),[u/i,2*Ia(vg(r/l,1/i))-Ie]},s}function PS(){return Wg(lO).scale(109.5).parallels([30,30])}function Wh(e,t){return[e,t]}Wh.invert=Wh;function LS(){return ws(Wh).scale(152.63)}function uO(e,t){var n=Kt(e),i=e===t?$t(e):(n-Kt(t))/(t-e),r=n/i+e;if(fe(i)<Wt)return Wh;function s(o,a){var c=r-a,l=i*o;return[c*$t(l),r-c*Kt(l)]}return s.invert=function(o,a){var c=r-a,l=Gr(o,fe(c))*fi(c);return c*i<0&&(l-=jt*fi(o)*fi(c)),[l/i,r-fi(i)*Bn(o*o+c*c)]},s}function NS(){return Wg(uO).scale(131.154).center([0,13.9389])}var hl=1.340264,dl=-.081106,pl=893e-6,ml=.003796,$h=Bn(3)/2,fO=12;function DS(e,t){var n=di($h*$t(t)),i=n*n,r=i*i*i;return[e*Kt(n)/($h*(hl+3*dl*i+r*(7*pl+9*ml*i))),n*(hl+dl*i+r*(pl+ml*i))]}DS.invert=function(e,t){for(var n=t,i=n*n,r=i*i*i,s=0,o,a,c;s<fO&&(a=n*(hl+dl*i+r*(pl+ml*i))-t,c=hl+3*dl*i+r*(7*pl+9*ml*i),n-=o=a/c,i=n*n,r=i*i*i,!(fe(o)<eS));++s);return[$h*e*(hl+3*dl*i+r*(7*pl+9*ml*i))/Kt(n),di($t(n)/$h)]};function FS(){return ws(DS).scale(177.158)}function US(e,t){var n=Kt(t),i=Kt(e)*n;return[n*$t(e)/i,$t(t)/i]}US.invert=bl(Ia);function OS(){return ws(US).scale(144.049).clipAngle(60)}function hO(e,t){var n=t*t,i=n*n;return[e*(.8707-.131979*n+i*(-.013791+i*(.003971*n-.001529*i))),t*(1.007226+n*(.015085+i*(-.044475+.028874*n-.005916*i)))]}hO.invert=function(e,t){var n=t,i=25,r;do{var s=n*n,o=s*s;n-=r=(n*(1.007226+s*(.015085+o*(-.044475+.028874*s-.005916*o)))-t)/(1.007226+s*(.015085*3+o*(-.044475*7+.028874*9*s-.005916*11*o)))}while(fe(r)>Wt&&--i>0);return[e/(.8707+(s=n*n)*(-.131979+s*(-.013791+s*s*s*(.003971-.001529*s)))),n]};function BS(e,t){return[Kt(t)*$t(e),$t(t)]}BS.invert=bl(di);function kS(){return ws(BS).scale(249.5).clipAngle(90+Wt)}function zS(e,t){var n=Kt(t),i=1+Kt(e)*n;return[n*$t(e)/i,$t(t)/i]}zS.invert=bl(function(e){return 2*Ia(e)});function GS(){return ws(zS).scale(250).clipAngle(142)}function VS(e,t){return[Dh(zg((Ie+t)/2)),-e]}VS.invert=function(e,t){return[-t,2*Ia(nS(e))-Ie]};function HS(){var e=IS(VS),t=e.center,n=e.rotate;return e.center=function(i){return arguments.length?t([-i[1],i[0]]):(i=t(),[i[1],-i[0]])},e.rotate=function(i){return arguments.length?n([i[0],i[1],i.length>2?i[2]+90:90]):(i=n(),[i[0],i[1],i[2]-90])},n([0,0,90]).scale(159.155)}var Xg=new Date,qg=new Date;function We(e,t,n,i){function r(s){return e(s=arguments.length===0?new Date:new Date(+s)),s}return r.floor=s=>(e(s=new Date(+s)),s),r.ceil=s=>(e(s=new Date(s-1)),t(s,1),e(s),s),r.round=s=>{let o=r(s),a=r.ceil(s);return s-o<a-s?o:a},r.offset=(s,o)=>(t(s=new Date(+s),o==null?1:Math.floor(o)),s),r.range=(s,o,a)=>{let c=[];if(s=r.ceil(s),a=a==null?1:Math.floor(a),!(s<o)||!(a>0))return c;let l;do c.push(l=new Date(+s)),t(s,a),e(s);while(l<s&&s<o);return c},r.filter=s=>We(o=>{if(o>=o)for(;e(o),!s(o);)o.setTime(o-1)},(o,a)=>{if(o>=o)if(a<0)for(;++a<=0;)for(;t(o,-1),!s(o););else for(;--a>=0;)for(;t(o,1),!s(o););}),n&&(r.count=(s,o)=>(Xg.setTime(+s),qg.setTime(+o),e(Xg),e(qg),Math.floor(n(Xg,qg))),r.every=s=>(s=Math.floor(s),!isFinite(s)||!(s>0)?null:s>1?r.filter(i?o=>i(o)%s===0:o=>r.count(0,o)%s===0):r)),r}var Yh=We(()=>{},(e,t)=>{e.setTime(+e+t)},(e,t)=>t-e);Yh.every=e=>(e=Math.floor(e),!isFinite(e)||!(e>0)?null:e>1?We(t=>{t.setTime(Math.floor(t/e)*e)},(t,n)=>{t.setTime(+t+n*e)},(t,n)=>(n-t)/e):Yh);var VG=Yh.range,Vr=1e3,pi=Vr*60,Hr=pi*60,Wr=Hr*24,Zg=Wr*7,WS=Wr*30,Yg=Wr*365,Rn=We(e=>{e.setTime(e-e.getMilliseconds())},(e,t)=>{e.setTime(+e+t*Vr)},(e,t)=>(t-e)/Vr,e=>e.getUTCSeconds()),HG=Rn.range,lo=We(e=>{e.setTime(e-e.getMilliseconds()-e.getSeconds()*Vr)},(e,t)=>{e.setTime(+e+t*pi)},(e,t)=>(t-e)/pi,e=>e.getMinutes()),WG=lo.range,uo=We(e=>{e.setUTCSeconds(0,0)},(e,t)=>{e.setTime(+e+t*pi)},(e,t)=>(t-e)/pi,e=>e.getUTCMinutes()),$G=uo.range,fo=We(e=>{e.setTime(e-e.getMilliseconds()-e.getSeconds()*Vr-e.getMinutes()*pi)},(e,t)=>{e.setTime(+e+t*Hr)},(e,t)=>(t-e)/Hr,e=>e.getHours()),XG=fo.range,ho=We(e=>{e.setUTCMinutes(0,0,0)},(e,t)=>{e.setTime(+e+t*Hr)},(e,t)=>(t-e)/Hr,e=>e.getUTCHours()),qG=ho.range,sr=We(e=>e.setHours(0,0,0,0),(e,t)=>e.setDate(e.getDate()+t),(e,t)=>(t-e-(t.getTimezoneOffset()-e.getTimezoneOffset())*pi)/Wr,e=>e.getDate()-1),YG=sr.range,Pa=We(e=>{e.setUTCHours(0,0,0,0)},(e,t)=>{e.setUTCDate(e.getUTCDate()+t)},(e,t)=>(t-e)/Wr,e=>e.getUTCDate()-1),ZG=Pa.range,Ml=We(e=>{e.setUTCHours(0,0,0,0)},(e,t)=>{e.setUTCDate(e.getUTCDate()+t)},(e,t)=>(t-e)/Wr,e=>Math.floor(e/Wr)),JG=Ml.range;function po(e){return We(t=>{t.setDate(t.getDate()-(t.getDay()+7-e)%7),t.setHours(0,0,0,0)},(t,n)=>{t.setDate(t.getDate()+n*7)},(t,n)=>(n-t-(n.getTimezoneOffset()-t.getTimezoneOffset())*pi)/Zg)}var or=po(0),mo=po(1),Jg=po(2),Kg=po(3),$r=po(4),jg=po(5),Qg=po(6),KG=or.range,jG=mo.range,QG=Jg.range,tV=Kg.range,eV=$r.range,nV=jg.range,iV=Qg.range;function go(e){return We(t=>{t.setUTCDate(t.getUTCDate()-(t.getUTCDay()+7-e)%7),t.setUTCHours(0,0,0,0)},(t,n)=>{t.setUTCDate(t.getUTCDate()+n*7)},(t,n)=>(n-t)/Zg)}var ar=go(0),yo=go(1),t0=go(2),e0=go(3),Xr=go(4),n0=go(5),i0=go(6),rV=ar.range,sV=yo.range,oV=t0.range,aV=e0.range,cV=Xr.range,lV=n0.range,uV=i0.range,xo=We(e=>{e.setDate(1),e.setHours(0,0,0,0)},(e,t)=>{e.setMonth(e.getMonth()+t)},(e,t)=>t.getMonth()-e.getMonth()+(t.getFullYear()-e.getFullYear())*12,e=>e.getMonth()),fV=xo.range,_o=We(e=>{e.setUTCDate(1),e.setUTCHours(0,0,0,0)},(e,t)=>{e.setUTCMonth(e.getUTCMonth()+t)},(e,t)=>t.getUTCMonth()-e.getUTCMonth()+(t.getUTCFullYear()-e.getUTCFullYear())*12,e=>e.getUTCMonth()),hV=_o.range,kn=We(e=>{e.setMonth(0,1),e.setHours(0,0,0,0)},(e,t)=>{e.setFullYear(e.getFullYear()+t)},(e,t)=>t.getFullYear()-e.getFullYear(),e=>e.getFullYear());kn.every=e=>!isFinite(e=Math.floor(e))||!(e>0)?null:We(t=>{t.setFullYear(Math.floor(t.getFullYear()/e)*e),t.setMonth(0,1),t.setHours(0,0,0,0)},(t,n)=>{t.setFullYear(t.getFullYear()+n*e)});var dV=kn.range,zn=We(e=>{e.setUTCMonth(0,1),e.setUTCHours(0,0,0,0)},(e,t)=>{e.setUTCFullYear(e.getUTCFullYear()+t)},(e,t)=>t.getUTCFullYear()-e.getUTCFullYear(),e=>e.getUTCFullYear());zn.every=e=>!isFinite(e=Math.floor(e))||!(e>0)?null:We(t=>{t.setUTCFullYear(Math.floor(t.getUTCFullYear()/e)*e),t.setUTCMonth(0,1),t.setUTCHours(0,0,0,0)},(t,n)=>{t.setUTCFullYear(t.getUTCFullYear()+n*e)});var pV=zn.range;function $S(e,t,n,i,r,s){let o=[[Rn,1,Vr],[Rn,5,5*Vr],[Rn,15,15*Vr],[Rn,30,30*Vr],[s,1,pi],[s,5,5*pi],[s,15,15*pi],[s,30,30*pi],[r,1,Hr],[r,3,3*Hr],[r,6,6*Hr],[r,12,12*Hr],[i,1,Wr],[i,2,2*Wr],[n,1,Zg],[t,1,WS],[t,3,3*WS],[e,1,Yg]];function a(l,u,h){let f=u<l;f&&([l,u]=[u,l]);let d=h&&typeof h.range=="function"?h:c(l,u,h),p=d?d.range(l,+u+1):[];return f?p.reverse():p}function c(l,u,h){let f=Math.abs(u-l)/h,d=pa(([,,m])=>m).right(o,f);if(d===o.length)return e.every(tl(l/Yg,u/Yg,h));if(d===0)return Yh.every(Math.max(tl(l,u,h),1));let[p,y]=o[f/o[d-1][2]<o[d][2]/f?d-1:d];return p.every(y)}return[a,c]}var[XS,Zh]=$S(zn,_o,ar,Ml,ho,uo),[qS,YS]=$S(kn,xo,or,sr,fo,lo);function r0(e){if(0<=e.y&&e.y<100){var t=new Date(-1,e.m,e.d,e.H,e.M,e.S,e.L);return t.setFullYear(e.y),t}return new Date(e.y,e.m,e.d,e.H,e.M,e.S,e.L)}function s0(e){if(0<=e.y&&e.y<100){var t=new Date(Date.UTC(-1,e.m,e.d,e.H,e.M,e.S,e.L));return t.setUTCFullYear(e.y),t}return new Date(Date.UTC(e.y,e.m,e.d,e.H,e.M,e.S,e.L))}function Sl(e,t,n){return{y:e,m:t,d:n,H:0,M:0,S:0,L:0}}function dO(e){var t=e.dateTime,n=e.date,i=e.time,r=e.periods,s=e.days,o=e.shortDays,a=e.months,c=e.shortMonths,l=wl(r),u=Tl(r),h=wl(s),f=Tl(s),d=wl(o),p=Tl(o),y=wl(a),m=Tl(a),g=wl(c),v=Tl(c),S={a:F,A:Z,b:U,B:G,c:null,d:tw,e:tw,f:UO,g:XO,G:YO,H:NO,I:DO,j:FO,L:sw,m:OO,M:BO,p:q,q:st,Q:iw,s:rw,S:kO,u:zO,U:GO,V:VO,w:HO,W:WO,x:null,X:null,y:$O,Y:qO,Z:ZO,"%":nw},_={a:ct,A:$,b:at,B:ft,c:null,d:ew,e:ew,f:QO,g:l4,G:f4,H:JO,I:KO,j:jO,L:aw,m:t4,M:e4,p:ot,q:rt,Q:iw,s:rw,S:n4,u:i4,U:r4,V:s4,w:o4,W:a4,x:null,X:null,y:c4,Y:u4,Z:h4,"%":nw},w={a:E,A:C,b:N,B,c:I,d:jS,e:jS,f:RO,g:KS,G:JS,H:QS,I:QS,j:TO,L:CO,m:wO,M:AO,p:R,q:SO,Q:PO,s:LO,S:EO,u:xO,U:_O,V:vO,w:yO,W:bO,x:L,X:k,y:KS,Y:JS,Z:MO,"%":IO};S.x=b(n,S),S.X=b(i,S),S.c=b(t,S),_.x=b(n,_),_.X=b(i,_),_.c=b(t,_);function b(J,gt){return function(lt){var K=[],It=-1,pt=0,Ut=J.length,Gt,ce,oe;for(lt instanceof Date||(lt=new Date(+lt));++It<Ut;)J.charCodeAt(It)===37&&(K.push(J.slice(pt,It)),(ce=ZS[Gt=J.charAt(++It)])!=null?Gt=J.charAt(++It):ce=Gt==="e"?" ":"0",(oe=gt[Gt])&&(Gt=oe(lt,ce)),K.push(Gt),pt=It+1);return K.push(J.slice(pt,It)),K.join("")}}function x(J,gt){return function(lt){var K=Sl(1900,void 0,1),It=M(K,J,lt+="",0),pt,Ut;if(It!=lt.length)return null;if("Q"in K)return new Date(K.Q);if("s"in K)return new Date(K.s*1e3+("L"in K?K.L:0));if(gt&&!("Z"in K)&&(K.Z=0),"p"in K&&(K.H=K.H%12+K.p*12),K.m===void 0&&(K.m="q"in K?K.q:0),"V"in K){if(K.V<1||K.V>53)return null;"w"in K||(K.w=1),"Z"in K?(pt=s0(Sl(K.y,0,1)),Ut=pt.getUTCDay(),pt=Ut>4||Ut===0?yo.ceil(pt):yo(pt),pt=Pa.offset(pt,(K.V-1)*7),K.y=pt.getUTCFullYear(),K.m=pt.getUTCMonth(),K.d=pt.getUTCDate()+(K.w+6)%7):(pt=r0(Sl(K.y,0,1)),Ut=pt.getDay(),pt=Ut>4||Ut===0?mo.ceil(pt):mo(pt),pt=sr.offset(pt,(K.V-1)*7),K.y=pt.getFullYear(),K.m=pt.getMonth(),K.d=pt.getDate()+(K.w+6)%7)}else("W"in K||"U"in K)&&("w"in K||(K.w="u"in K?K.u%7:"W"in K?1:0),Ut="Z"in K?s0(Sl(K.y,0,1)).getUTCDay():r0(Sl(K.y,0,1)).getDay(),K.m=0,K.d="W"in K?(K.w+6)%7+K.W*7-(Ut+5)%7:K.w+K.U*7-(Ut+6)%7);return"Z"in K?(K.H+=K.Z/100|0,K.M+=K.Z%100,s0(K)):r0(K)}}function M(J,gt,lt,K){for(var It=0,pt=gt.length,Ut=lt.length,Gt,ce;It<pt;){if(K>=Ut)return-1;if(Gt=gt.charCodeAt(It++),Gt===37){if(Gt=gt.charAt(It++),ce=w[Gt in ZS?gt.charAt(It++):Gt],!ce||(K=ce(J,lt,K))<0)return-1}else if(Gt!=lt.charCodeAt(K++))return-1}return K}function R(J,gt,lt){var K=l.exec(gt.slice(lt));return K?(J.p=u.get(K[0].toLowerCase()),lt+K[0].length):-1}function E(J,gt,lt){var K=d.exec(gt.slice(lt));return K?(J.w=p.get(K[0].toLowerCase()),lt+K[0].length):-1}function C(J,gt,lt){var K=h.exec(gt.slice(lt));return K?(J.w=f.get(K[0].toLowerCase()),lt+K[0].length):-1}function N(J,gt,lt){var K=g.exec(gt.slice(lt));return K?(J.m=v.get(K[0].toLowerCase()),lt+K[0].length):-1}function B(J,gt,lt){var K=y.exec(gt.slice(lt));return K?(J.m=m.get(K[0].toLowerCase()),lt+K[0].length):-1}function I(J,gt,lt){return M(J,t,gt,lt)}function L(J,gt,lt){return M(J,n,gt,lt)}function k(J,gt,lt){return M(J,i,gt,lt)}function F(J){return o[J.getDay()]}function Z(J){return s[J.getDay()]}function U(J){return c[J.getMonth()]}function G(J){return a[J.getMonth()]}function q(J){return r[+(J.getHours()>=12)]}function st(J){return 1+~~(J.getMonth()/3)}function ct(J){return o[J.getUTCDay()]}function $(J){return s[J.getUTCDay()]}function at(J){return c[J.getUTCMonth()]}function ft(J){return a[J.getUTCMonth()]}function ot(J){return r[+(J.getUTCHours()>=12)]}function rt(J){return 1+~~(J.getUTCMonth()/3)}return{format:function(J){var gt=b(J+="",S);return gt.toString=function(){return J},gt},parse:function(J){var gt=x(J+="",!1);return gt.toString=function(){return J},gt},utcFormat:function(J){var gt=b(J+="",_);return gt.toString=function(){return J},gt},utcParse:function(J){var gt=x(J+="",!0);return gt.toString=function(){return J},gt}}}var ZS={"-":"",_:" ",0:"0"},en=/^\s*\d+/,pO=/^%/,mO=/[\\^$*+?|[\]().{}]/g;function ae(e,t,n){var i=e<0?"-":"",r=(i?-e:e)+"",s=r.length;return i+(s<n?new Array(n-s+1).join(t)+r:r)}function gO(e){return e.replace(mO,"\\$&")}function wl(e){return new RegExp("^(?:"+e.map(gO).join("|")+")","i")}function Tl(e){return new Map(e.map((t,n)=>[t.toLowerCase(),n]))}function yO(e,t,n){var i=en.exec(t.slice(n,n+1));return i?(e.w=+i[0],n+i[0].length):-1}function xO(e,t,n){var i=en.exec(t.slice(n,n+1));return i?(e.u=+i[0],n+i[0].length):-1}function _O(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.U=+i[0],n+i[0].length):-1}function vO(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.V=+i[0],n+i[0].length):-1}function bO(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.W=+i[0],n+i[0].length):-1}function JS(e,t,n){var i=en.exec(t.slice(n,n+4));return i?(e.y=+i[0],n+i[0].length):-1}function KS(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.y=+i[0]+(+i[0]>68?1900:2e3),n+i[0].length):-1}function MO(e,t,n){var i=/^(Z)|([+-]\d\d)(?::?(\d\d))?/.exec(t.slice(n,n+6));return i?(e.Z=i[1]?0:-(i[2]+(i[3]||"00")),n+i[0].length):-1}function SO(e,t,n){var i=en.exec(t.slice(n,n+1));return i?(e.q=i[0]*3-3,n+i[0].length):-1}function wO(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.m=i[0]-1,n+i[0].length):-1}function jS(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.d=+i[0],n+i[0].length):-1}function TO(e,t,n){var i=en.exec(t.slice(n,n+3));return i?(e.m=0,e.d=+i[0],n+i[0].length):-1}function QS(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.H=+i[0],n+i[0].length):-1}function AO(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.M=+i[0],n+i[0].length):-1}function EO(e,t,n){var i=en.exec(t.slice(n,n+2));return i?(e.S=+i[0],n+i[0].length):-1}function CO(e,t,n){var i=en.exec(t.slice(n,n+3));return i?(e.L=+i[0],n+i[0].length):-1}function RO(e,t,n){var i=en.exec(t.slice(n,n+6));return i?(e.L=Math.floor(i[0]/1e3),n+i[0].length):-1}function IO(e,t,n){var i=pO.exec(t.slice(n,n+1));return i?n+i[0].length:-1}function PO(e,t,n){var i=en.exec(t.slice(n));return i?(e.Q=+i[0],n+i[0].length):-1}function LO(e,t,n){var i=en.exec(t.slice(n));return i?(e.s=+i[0],n+i[0].length):-1}function tw(e,t){return ae(e.getDate(),t,2)}function NO(e,t){return ae(e.getHours(),t,2)}function DO(e,t){return ae(e.getHours()%12||12,t,2)}function FO(e,t){return ae(1+sr.count(kn(e),e),t,3)}function sw(e,t){return ae(e.getMilliseconds(),t,3)}function UO(e,t){return sw(e,t)+"000"}function OO(e,t){return ae(e.getMonth()+1,t,2)}function BO(e,t){return ae(e.getMinutes(),t,2)}function kO(e,t){return ae(e.getSeconds(),t,2)}function zO(e){var t=e.getDay();return t===0?7:t}function GO(e,t){return ae(or.count(kn(e)-1,e),t,2)}function ow(e){var t=e.getDay();return t>=4||t===0?$r(e):$r.ceil(e)}function VO(e,t){return e=ow(e),ae($r.count(kn(e),e)+(kn(e).getDay()===4),t,2)}function HO(e){return e.getDay()}function WO(e,t){return ae(mo.count(kn(e)-1,e),t,2)}function $O(e,t){return ae(e.getFullYear()%100,t,2)}function XO(e,t){return e=ow(e),ae(e.getFullYear()%100,t,2)}function qO(e,t){return ae(e.getFullYear()%1e4,t,4)}function YO(e,t){var n=e.getDay();return e=n>=4||n===0?$r(e):$r.ceil(e),ae(e.getFullYear()%1e4,t,4)}function ZO(e){var t=e.getTimezoneOffset();return(t>0?"-":(t*=-1,"+"))+ae(t/60|0,"0",2)+ae(t%60,"0",2)}function ew(e,t){return ae(e.getUTCDate(),t,2)}function JO(e,t){return ae(e.getUTCHours(),t,2)}function KO(e,t){return ae(e.getUTCHours()%12||12,t,2)}function jO(e,t){return ae(1+Pa.count(zn(e),e),t,3)}function aw(e,t){return ae(e.getUTCMilliseconds(),t,3)}function QO(e,t){return aw(e,t)+"000"}function t4(e,t){return ae(e.getUTCMonth()+1,t,2)}function e4(e,t){return ae(e.getUTCMinutes(),t,2)}function n4(e,t){return ae(e.getUTCSeconds(),t,2)}function i4(e){var t=e.getUTCDay();return t===0?7:t}function r4(e,t){return ae(ar.count(zn(e)-1,e),t,2)}function cw(e){var t=e.getUTCDay();return t>=4||t===0?Xr(e):Xr.ceil(e)}function s4(e,t){return e=cw(e),ae(Xr.count(zn(e),e)+(zn(e).getUTCDay()===4),t,2)}function o4(e){return e.getUTCDay()}function a4(e,t){return ae(yo.count(zn(e)-1,e),t,2)}function c4(e,t){return ae(e.getUTCFullYear()%100,t,2)}function l4(e,t){return e=cw(e),ae(e.getUTCFullYear()%100,t,2)}function u4(e,t){return ae(e.getUTCFullYear()%1e4,t,4)}function f4(e,t){var n=e.getUTCDay();return e=n>=4||n===0?Xr(e):Xr.ceil(e),ae(e.getUTCFullYear()%1e4,t,4)}function h4(){return"+0000"}function nw(){return"%"}function iw(e){return+e}function rw(e){return Math.floor(+e/1e3)}var La,Al,d4,cr,lw;p4({dateTime:"%x, %X",date:"%-m/%-d/%Y",time:"%-I:%M:%S %p",periods:["AM","PM"],days:["Sunday","Monday","Tuesday","Wednesday","Thursday","Friday","Saturday"],shortDays:["Sun","Mon","Tue","Wed","Thu","Fri","Sat"],months:["January","February","March","April","May","June","July","August","September","October","November","December"],shortMonths:["Jan","Feb","Mar","Apr","May","Jun","Jul","Aug","Sep","Oct","Nov","Dec"]});function p4(e){return La=dO(e),Al=La.format,d4=La.parse,cr=La.utcFormat,lw=La.utcParse,La}var uw="%Y-%m-%dT%H:%M:%S.%LZ";function m4(e){return e.toISOString()}var yV=Date.prototype.toISOString?m4:cr(uw);function g4(e){var t=new Date(e);return isNaN(t)?null:t}var xV=+new Date("2000-01-01T00:00:00.000Z")?g4:lw(uw);function lr(e,t){switch(arguments.length){case 0:break;case 1:this.range(e);break;default:this.range(t).domain(e);break}return this}function Kh(e,t){switch(arguments.length){case 0:break;case 1:{typeof e=="function"?this.interpolator(e):this.range(e);break}default:{this.domain(e),typeof t=="function"?this.interpolator(t):this.range(t);break}}return this}var Jh=Symbol("implicit");function jh(){var e=new ai,t=[],n=[],i=Jh;function r(s){let o=e.get(s);if(o===void 0){if(i!==Jh)return i;e.set(s,o=t.push(s)-1)}return n[o%n.length]}return r.domain=function(s){if(!arguments.length)return t.slice();t=[],e=new ai;for(let o of s)e.has(o)||e.set(o,t.push(o)-1);return r},r.range=function(s){return arguments.length?(n=Array.from(s),r):n.slice()},r.unknown=function(s){return arguments.length?(i=s,r):i},r.copy=function(){return jh(t,n).unknown(i)},lr.apply(r,arguments),r}function Na(){var e=jh().unknown(void 0),t=e.domain,n=e.range,i=0,r=1,s,o,a=!1,c=0,l=0,u=.5;delete e.unknown;function h(){var f=t().length,d=r<i,p=d?r:i,y=d?i:r;s=(y-p)/Math.max(1,f-c+l*2),a&&(s=Math.floor(s)),p+=(y-p-s*(f-c))*u,o=s*(1-c),a&&(p=Math.round(p),o=Math.round(o));var m=ga(f).map(function(g){return p+s*g});return n(d?m.reverse():m)}return e.domain=function(f){return arguments.length?(t(f),h()):t()},e.range=function(f){return arguments.length?([i,r]=f,i=+i,r=+r,h()):[i,r]},e.rangeRound=function(f){return[i,r]=f,i=+i,r=+r,a=!0,h()},e.bandwidth=function(){return o},e.step=function(){return s},e.round=function(f){return arguments.length?(a=!!f,h()):a},e.padding=function(f){return arguments.length?(c=Math.min(1,l=+f),h()):c},e.paddingInner=function(f){return arguments.length?(c=Math.min(1,f),h()):c},e.paddingOuter=function(f){return arguments.length?(l=+f,h()):l},e.align=function(f){return arguments.length?(u=Math.max(0,Math.min(1,f)),h()):u},e.copy=function(){return Na(t(),[i,r]).round(a).paddingInner(c).paddingOuter(l).align(u)},lr.apply(h(),arguments)}function xw(e){var t=e.copy;return e.padding=e.paddingOuter,delete e.paddingInner,delete e.paddingOuter,e.copy=function(){return xw(t())},e}function _w(){return xw(Na.apply(null,arguments).paddingInner(1))}function y4(e){return function(){return e}}function o0(e){return+e}var fw=[0,1];function mi(e){return e}function a0(e,t){return(t-=e=+e)?function(n){return(n-e)/t}:y4(isNaN(t)?NaN:.5)}function x4(e,t){var n;return e>t&&(n=e,e=t,t=n),function(i){return Math.max(e,Math.min(t,i))}}function _4(e,t,n){var i=e[0],r=e[1],s=t[0],o=t[1];return r<i?(i=a0(r,i),s=n(o,s)):(i=a0(i,r),s=n(s,o)),function(a){return s(i(a))}}function v4(e,t,n){var i=Math.min(e.length,t.length)-1,r=new Array(i),s=new Array(i),o=-1;for(e[i]<e[0]&&(e=e.slice().reverse(),t=t.slice().reverse());++o<i;)r[o]=a0(e[o],e[o+1]),s[o]=n(t[o],t[o+1]);return function(a){var c=ma(e,a,1,i)-1;return s[c](r[c](a))}}function El(e,t){return t.domain(e.domain()).range(e.range()).interpolate(e.interpolate()).clamp(e.clamp()).unknown(e.unknown())}function Qh(){var e=fw,t=fw,n=wa,i,r,s,o=mi,a,c,l;function u(){var f=Math.min(e.length,t.length);return o!==mi&&(o=x4(e[0],e[f-1])),a=f>2?v4:_4,c=l=null,h}function h(f){return f==null||isNaN(f=+f)?s:(c||(c=a(e.map(i),t,n)))(i(o(f)))}return h.invert=function(f){return o(r((l||(l=a(t,e.map(i),He)))(f)))},h.domain=function(f){return arguments.length?(e=Array.from(f,o0),u()):e.slice()},h.range=function(f){return arguments.length?(t=Array.from(f),u()):t.slice()},h.rangeRound=function(f){return t=Array.from(f),n=sl,u()},h.clamp=function(f){return arguments.length?(o=f?!0:mi,u()):o!==mi},h.interpolate=function(f){return arguments.length?(n=f,u()):n},h.unknown=function(f){return arguments.length?(s=f,h):s},function(f,d){return i=f,r=d,u()}}function vw(){return Qh()(mi,mi)}function b4(e,t,n,i){var r=tl(e,t,n),s;switch(i=Aa(i??",f"),i.type){case"s":{var o=Math.max(Math.abs(e),Math.abs(t));return i.precision==null&&!isNaN(s=FM(r,o))&&(i.precision=s),_g(i,o)}case"":case"e":case"g":case"p":case"r":{i.precision==null&&!isNaN(s=UM(r,Math.max(Math.abs(e),Math.abs(t))))&&(i.precision=s-(i.type==="e"));break}case"f":case"%":{i.precision==null&&!isNaN(s=DM(r))&&(i.precision=s-(i.type==="%")*2);break}}return nr(i)}function Cl(e){var t=e.domain;return e.ticks=function(n){var i=t();return _s(i[0],i[i.length-1],n??10)},e.tickFormat=function(n,i){var r=t();return b4(r[0],r[r.length-1],n??10,i)},e.nice=function(n){n==null&&(n=10);var i=t(),r=0,s=i.length-1,o=i[r],a=i[s],c,l,u=10;for(a<o&&(l=o,o=a,a=l,l=r,r=s,s=l);u-- >0;){if(l=da(o,a,n),l===c)return i[r]=o,i[s]=a,t(i);if(l>0)o=Math.floor(o/l)*l,a=Math.ceil(a/l)*l;else if(l<0)o=Math.ceil(o*l)/l,a=Math.floor(a*l)/l;else break;c=l}return e},e}function Rl(){var e=vw();return e.copy=function(){return El(e,Rl())},lr.apply(e,arguments),Cl(e)}function c0(e){var t;function n(i){return i==null||isNaN(i=+i)?t:i}return n.invert=n,n.domain=n.range=function(i){return arguments.length?(e=Array.from(i,o0),n):e.slice()},n.unknown=function(i){return arguments.length?(t=i,n):t},n.copy=function(){return c0(e).unknown(t)},e=arguments.length?Array.from(e,o0):[0,1],Cl(n)}function bw(e,t){e=e.slice();var n=0,i=e.length-1,r=e[n],s=e[i],o;return s<r&&(o=n,n=i,i=o,o=r,r=s,s=o),e[n]=t.floor(r),e[i]=t.ceil(s),e}function hw(e){return Math.log(e)}function dw(e){return Math.exp(e)}function M4(e){return-Math.log(-e)}function S4(e){return-Math.exp(-e)}function w4(e){return isFinite(e)?+("1e"+e):e<0?0:e}function T4(e){return e===10?w4:e===Math.E?Math.exp:t=>Math.pow(e,t)}function A4(e){return e===Math.E?Math.log:e===10&&Math.log10||e===2&&Math.log2||(e=Math.log(e),t=>Math.log(t)/e)}function pw(e){return(t,n)=>-e(-t,n)}function Mw(e){let t=e(hw,dw),n=t.domain,i=10,r,s;function o(){return r=A4(i),s=T4(i),n()[0]<0?(r=pw(r),s=pw(s),e(M4,S4)):e(hw,dw),t}return t.base=function(a){return arguments.length?(i=+a,o()):i},t.domain=function(a){return arguments.length?(n(a),o()):n()},t.ticks=a=>{let c=n(),l=c[0],u=c[c.length-1],h=u<l;h&&([l,u]=[u,l]);let f=r(l),d=r(u),p,y,m=a==null?10:+a,g=[];if(!(i%1)&&d-f<m){if(f=Math.floor(f),d=Math.ceil(d),l>0){for(;f<=d;++f)for(p=1;p<i;++p)if(y=f<0?p/s(-f):p*s(f),!(y<l)){if(y>u)break;g.push(y)}}else for(;f<=d;++f)for(p=i-1;p>=1;--p)if(y=f>0?p/s(-f):p*s(f),!(y<l)){if(y>u)break;g.push(y)}g.length*2<m&&(g=_s(l,u,m))}else g=_s(f,d,Math.min(d-f,m)).map(s);return h?g.reverse():g},t.tickFormat=(a,c)=>{if(a==null&&(a=10),c==null&&(c=i===10?"s":","),typeof c!="function"&&(!(i%1)&&(c=Aa(c)).precision==null&&(c.trim=!0),c=nr(c)),a===1/0)return c;let l=Math.max(1,i*a/t.ticks().length);return u=>{let h=u/s(Math.round(r(u)));return h*i<i-.5&&(h*=i),h<=l?c(u):""}},t.nice=()=>n(bw(n(),{floor:a=>s(Math.floor(r(a))),ceil:a=>s(Math.ceil(r(a)))})),t}function l0(){let e=Mw(Qh()).domain([1,10]);return e.copy=()=>El(e,l0()).base(e.base()),lr.apply(e,arguments),e}function mw(e){return function(t){return Math.sign(t)*Math.log1p(Math.abs(t/e))}}function gw(e){return function(t){return Math.sign(t)*Math.expm1(Math.abs(t))*e}}function Sw(e){var t=1,n=e(mw(t),gw(t));return n.constant=function(i){return arguments.length?e(mw(t=+i),gw(t)):t},Cl(n)}function u0(){var e=Sw(Qh());return e.copy=function(){return El(e,u0()).constant(e.constant())},lr.apply(e,arguments)}function yw(e){return function(t){return t<0?-Math.pow(-t,e):Math.pow(t,e)}}function E4(e){return e<0?-Math.sqrt(-e):Math.sqrt(e)}function C4(e){return e<0?-e*e:e*e}function ww(e){var t=e(mi,mi),n=1;function i(){return n===1?e(mi,mi):n===.5?e(E4,C4):e(yw(n),yw(1/n))}return t.exponent=function(r){return arguments.length?(n=+r,i()):n},Cl(t)}function f0(){var e=ww(Qh());return e.copy=function(){return El(e,f0()).exponent(e.exponent())},lr.apply(e,arguments),e}function h0(){var e=[],t=[],n=[],i;function r(){var o=0,a=Math.max(1,t.length);for(n=new Array(a-1);++o<a;)n[o-1]=A1(e,o/a);return s}function s(o){return o==null||isNaN(o=+o)?i:t[ma(n,o)]}return s.invertExtent=function(o){var a=t.indexOf(o);return a<0?[NaN,NaN]:[a>0?n[a-1]:e[0],a<n.length?n[a]:e[e.length-1]]},s.domain=function(o){if(!arguments.length)return e.slice();e=[];for(let a of o)a!=null&&!isNaN(a=+a)&&e.push(a);return e.sort(gn),r()},s.range=function(o){return arguments.length?(t=Array.from(o),r()):t.slice()},s.unknown=function(o){return arguments.length?(i=o,s):i},s.quantiles=function(){return n.slice()},s.copy=function(){return h0().domain(e).range(t).unknown(i)},lr.apply(s,arguments)}function d0(){var e=[.5],t=[0,1],n,i=1;function r(s){return s!=null&&s<=s?t[ma(e,s,0,i)]:n}return r.domain=function(s){return arguments.length?(e=Array.from(s),i=Math.min(e.length,t.length-1),r):e.slice()},r.range=function(s){return arguments.length?(t=Array.from(s),i=Math.min(e.length,t.length-1),r):t.slice()},r.invertExtent=function(s){var o=t.indexOf(s);return[e[o-1],e[o]]},r.unknown=function(s){return arguments.length?(n=s,r):n},r.copy=function(){return d0().domain(e).range(t).unknown(n)},lr.apply(r,arguments)}function R4(e){return new Date(e)}function I4(e){return e instanceof Date?+e:Math.round(e)}function p0(e,t,n,i,r,s,o,a,c,l){var u=vw(),h=u.invert,f=u.domain,d=l(".%L"),p=l(":%S"),y=l("%I:%M"),m=l("%I %p"),g=l("%a %d"),v=l("%b %d"),S=l("%B"),_=l("%Y");function w(b){return(c(b)<b?d:a(b)<b?p:o(b)<b?y:s(b)<b?m:i(b)<b?r(b)<b?g:v:n(b)<b?S:_)(b)}return u.invert=function(b){return new Date(Math.round(h(b)))},u.domain=function(b){return arguments.length?f(Array.from(b,I4)):f().map(R4)},u.ticks=function(b){var x=f();return e(x[0],x[x.length-1],b??10)},u.tickFormat=function(b,x){return x==null?w:l(x)},u.nice=function(b){var x=f();return(!b||typeof b.range!="function")&&(b=t(x[0],x[x.length-1],b??10)),b?f(bw(x,b)):u},u.copy=function(){return El(u,p0(e,t,n,i,r,s,o,a,c,l))},u}function Tw(){return lr.apply(p0(qS,YS,kn,xo,or,sr,fo,lo,Rn,Al).domain([new Date(2e3,0,1),new Date(2e3,0,2)]),arguments)}function Aw(){return lr.apply(p0(XS,Zh,zn,_o,ar,Pa,ho,uo,Rn,cr).domain([Date.UTC(2e3,0,1),Date.UTC(2e3,0,2)]),arguments)}function td(e,t){return t.domain(e.domain()).interpolator(e.interpolator()).clamp(e.clamp()).unknown(e.unknown())}function ed(){var e=0,t=.5,n=1,i=1,r,s,o,a,c,l=mi,u,h=!1,f;function d(y){return y==null||isNaN(y=+y)?f:(y=.5+((y=+u(y))-s)*(i*y<i*s?a:c),l(h?Math.max(0,Math.min(1,y)):y))}d.domain=function(y){return arguments.length?([e,t,n]=y,r=u(e=+e),s=u(t=+t),o=u(n=+n),a=r===s?0:.5/(s-r),c=s===o?0:.5/(o-s),i=s<r?-1:1,d):[e,t,n]},d.clamp=function(y){return arguments.length?(h=!!y,d):h},d.interpolator=function(y){return arguments.length?(l=y,d):l};function p(y){return function(m){var g,v,S;return arguments.length?([g,v,S]=m,l=Ms(y,[g,v,S]),d):[l(0),l(.5),l(1)]}}return d.range=p(wa),d.rangeRound=p(sl),d.unknown=function(y){return arguments.length?(f=y,d):f},function(y){return u=y,r=y(e),s=y(t),o=y(n),a=r===s?0:.5/(s-r),c=s===o?0:.5/(o-s),i=s<r?-1:1,d}}function m0(){var e=Cl(ed()(mi));return e.copy=function(){return td(e,m0())},Kh.apply(e,arguments)}function g0(){var e=Mw(ed()).domain([.1,1,10]);return e.copy=function(){return td(e,g0()).base(e.base())},Kh.apply(e,arguments)}function y0(){var e=Sw(ed());return e.copy=function(){return td(e,y0()).constant(e.constant())},Kh.apply(e,arguments)}function x0(){var e=ww(ed());return e.copy=function(){return td(e,x0()).exponent(e.exponent())},Kh.apply(e,arguments)}function Xt(e){for(var t=e.length/6|0,n=new Array(t),i=0;i<t;)n[i]="#"+e.slice(i*6,++i*6);return n}var Ew=Xt("1f77b4ff7f0e2ca02cd627289467bd8c564be377c27f7f7fbcbd2217becf"),Cw=Xt("7fc97fbeaed4fdc086ffff99386cb0f0027fbf5b17666666"),Rw=Xt("1b9e77d95f027570b3e7298a66a61ee6ab02a6761d666666"),Iw=Xt("4269d0efb118ff725c6cc5b03ca951ff8ab7a463f297bbf59c6b4e9498a0"),Pw=Xt("a6cee31f78b4b2df8a33a02cfb9a99e31a1cfdbf6fff7f00cab2d66a3d9affff99b15928"),Lw=Xt("fbb4aeb3cde3ccebc5decbe4fed9a6ffffcce5d8bdfddaecf2f2f2"),Nw=Xt("b3e2cdfdcdaccbd5e8f4cae4e6f5c9fff2aef1e2cccccccc"),Dw=Xt("e41a1c377eb84daf4a984ea3ff7f00ffff33a65628f781bf999999"),Fw=Xt("66c2a5fc8d628da0cbe78ac3a6d854ffd92fe5c494b3b3b3"),Uw=Xt("8dd3c7ffffb3bebadafb807280b1d3fdb462b3de69fccde5d9d9d9bc80bdccebc5ffed6f"),Ow=Xt("4e79a7f28e2ce1575976b7b259a14fedc949af7aa1ff9da79c755fbab0ab"),xe=e=>xM(e[e.length-1]),_0=new Array(3).concat("d8b365f5f5f55ab4ac","a6611adfc27d80cdc1018571","a6611adfc27df5f5f580cdc1018571","8c510ad8b365f6e8c3c7eae55ab4ac01665e","8c510ad8b365f6e8c3f5f5f5c7eae55ab4ac01665e","8c510abf812ddfc27df6e8c3c7eae580cdc135978f01665e","8c510abf812ddfc27df6e8c3f5f5f5c7eae580cdc135978f01665e","5430058c510abf812ddfc27df6e8c3c7eae580cdc135978f01665e003c30","5430058c510abf812ddfc27df6e8c3f5f5f5c7eae580cdc135978f01665e003c30").map(Xt),v0=xe(_0),b0=new Array(3).concat("af8dc3f7f7f77fbf7b","7b3294c2a5cfa6dba0008837","7b3294c2a5cff7f7f7a6dba0008837","762a83af8dc3e7d4e8d9f0d37fbf7b1b7837","762a83af8dc3e7d4e8f7f7f7d9f0d37fbf7b1b7837","762a839970abc2a5cfe7d4e8d9f0d3a6dba05aae611b7837","762a839970abc2a5cfe7d4e8f7f7f7d9f0d3a6dba05aae611b7837","40004b762a839970abc2a5cfe7d4e8d9f0d3a6dba05aae611b783700441b","40004b762a839970abc2a5cfe7d4e8f7f7f7d9f0d3a6dba05aae611b783700441b").map(Xt),M0=xe(b0),S0=new Array(3).concat("e9a3c9f7f7f7a1d76a","d01c8bf1b6dab8e1864dac26","d01c8bf1b6daf7f7f7b8e1864dac26","c51b7de9a3c9fde0efe6f5d0a1d76a4d9221","c51b7de9a3c9fde0eff7f7f7e6f5d0a1d76a4d9221","c51b7dde77aef1b6dafde0efe6f5d0b8e1867fbc414d9221","c51b7dde77aef1b6dafde0eff7f7f7e6f5d0b8e1867fbc414d9221","8e0152c51b7dde77aef1b6dafde0efe6f5d0b8e1867fbc414d9221276419","8e0152c51b7dde77aef1b6dafde0eff7f7f7e6f5d0b8e1867fbc414d9221276419").map(Xt),w0=xe(S0),T0=new Array(3).concat("998ec3f7f7f7f1a340","5e3c99b2abd2fdb863e66101","5e3c99b2abd2f7f7f7fdb863e66101","542788998ec3d8daebfee0b6f1a340b35806","542788998ec3d8daebf7f7f7fee0b6f1a340b35806","5427888073acb2abd2d8daebfee0b6fdb863e08214b35806","5427888073acb2abd2d8daebf7f7f7fee0b6fdb863e08214b35806","2d004b5427888073acb2abd2d8daebfee0b6fdb863e08214b358067f3b08","2d004b5427888073acb2abd2d8daebf7f7f7fee0b6fdb863e08214b358067f3b08").map(Xt),A0=xe(T0),rd=new Array(3).concat("ef8a62f7f7f767a9cf","ca0020f4a58292c5de0571b0","ca0020f4a582f7f7f792c5de0571b0","b2182bef8a62fddbc7d1e5f067a9cf2166ac","b2182bef8a62fddbc7f7f7f7d1e5f067a9cf2166ac","b2182bd6604df4a582fddbc7d1e5f092c5de4393c32166ac","b2182bd6604df4a582fddbc7f7f7f7d1e5f092c5de4393c32166ac","67001fb2182bd6604df4a582fddbc7d1e5f092c5de4393c32166ac053061","67001fb2182bd6604df4a582fddbc7f7f7f7d1e5f092c5de4393c32166ac053061").map(Xt),Il=xe(rd),E0=new Array(3).concat("ef8a62ffffff999999","ca0020f4a582bababa404040","ca0020f4a582ffffffbababa404040","b2182bef8a62fddbc7e0e0e09999994d4d4d","b2182bef8a62fddbc7ffffffe0e0e09999994d4d4d","b2182bd6604df4a582fddbc7e0e0e0bababa8787874d4d4d","b2182bd6604df4a582fddbc7ffffffe0e0e0bababa8787874d4d4d","67001fb2182bd6604df4a582fddbc7e0e0e0bababa8787874d4d4d1a1a1a","67001fb2182bd6604df4a582fddbc7ffffffe0e0e0bababa8787874d4d4d1a1a1a").map(Xt),C0=xe(E0),sd=new Array(3).concat("fc8d59ffffbf91bfdb","d7191cfdae61abd9e92c7bb6","d7191cfdae61ffffbfabd9e92c7bb6","d73027fc8d59fee090e0f3f891bfdb4575b4","d73027fc8d59fee090ffffbfe0f3f891bfdb4575b4","d73027f46d43fdae61fee090e0f3f8abd9e974add14575b4","d73027f46d43fdae61fee090ffffbfe0f3f8abd9e974add14575b4","a50026d73027f46d43fdae61fee090e0f3f8abd9e974add14575b4313695","a50026d73027f46d43fdae61fee090ffffbfe0f3f8abd9e974add14575b4313695").map(Xt),Pl=xe(sd),R0=new Array(3).concat("fc8d59ffffbf91cf60","d7191cfdae61a6d96a1a9641","d7191cfdae61ffffbfa6d96a1a9641","d73027fc8d59fee08bd9ef8b91cf601a9850","d73027fc8d59fee08bffffbfd9ef8b91cf601a9850","d73027f46d43fdae61fee08bd9ef8ba6d96a66bd631a9850","d73027f46d43fdae61fee08bffffbfd9ef8ba6d96a66bd631a9850","a50026d73027f46d43fdae61fee08bd9ef8ba6d96a66bd631a9850006837","a50026d73027f46d43fdae61fee08bffffbfd9ef8ba6d96a66bd631a9850006837").map(Xt),I0=xe(R0),P0=new Array(3).concat("fc8d59ffffbf99d594","d7191cfdae61abdda42b83ba","d7191cfdae61ffffbfabdda42b83ba","d53e4ffc8d59fee08be6f59899d5943288bd","d53e4ffc8d59fee08bffffbfe6f59899d5943288bd","d53e4ff46d43fdae61fee08be6f598abdda466c2a53288bd","d53e4ff46d43fdae61fee08bffffbfe6f598abdda466c2a53288bd","9e0142d53e4ff46d43fdae61fee08be6f598abdda466c2a53288bd5e4fa2","9e0142d53e4ff46d43fdae61fee08bffffbfe6f598abdda466c2a53288bd5e4fa2").map(Xt),L0=xe(P0),N0=new Array(3).concat("e5f5f999d8c92ca25f","edf8fbb2e2e266c2a4238b45","edf8fbb2e2e266c2a42ca25f006d2c","edf8fbccece699d8c966c2a42ca25f006d2c","edf8fbccece699d8c966c2a441ae76238b45005824","f7fcfde5f5f9ccece699d8c966c2a441ae76238b45005824","f7fcfde5f5f9ccece699d8c966c2a441ae76238b45006d2c00441b").map(Xt),D0=xe(N0),F0=new Array(3).concat("e0ecf49ebcda8856a7","edf8fbb3cde38c96c688419d","edf8fbb3cde38c96c68856a7810f7c","edf8fbbfd3e69ebcda8c96c68856a7810f7c","edf8fbbfd3e69ebcda8c96c68c6bb188419d6e016b","f7fcfde0ecf4bfd3e69ebcda8c96c68c6bb188419d6e016b","f7fcfde0ecf4bfd3e69ebcda8c96c68c6bb188419d810f7c4d004b").map(Xt),U0=xe(F0),O0=new Array(3).concat("e0f3dba8ddb543a2ca","f0f9e8bae4bc7bccc42b8cbe","f0f9e8bae4bc7bccc443a2ca0868ac","f0f9e8ccebc5a8ddb57bccc443a2ca0868ac","f0f9e8ccebc5a8ddb57bccc44eb3d32b8cbe08589e","f7fcf0e0f3dbccebc5a8ddb57bccc44eb3d32b8cbe08589e","f7fcf0e0f3dbccebc5a8ddb57bccc44eb3d32b8cbe0868ac084081").map(Xt),B0=xe(O0),k0=new Array(3).concat("fee8c8fdbb84e34a33","fef0d9fdcc8afc8d59d7301f","fef0d9fdcc8afc8d59e34a33b30000","fef0d9fdd49efdbb84fc8d59e34a33b30000","fef0d9fdd49efdbb84fc8d59ef6548d7301f990000","fff7ecfee8c8fdd49efdbb84fc8d59ef6548d7301f990000","fff7ecfee8c8fdd49efdbb84fc8d59ef6548d7301fb300007f0000").map(Xt),z0=xe(k0),G0=new Array(3).concat("ece2f0a6bddb1c9099","f6eff7bdc9e167a9cf02818a","f6eff7bdc9e167a9cf1c9099016c59","f6eff7d0d1e6a6bddb67a9cf1c9099016c59","f6eff7d0d1e6a6bddb67a9cf3690c002818a016450","fff7fbece2f0d0d1e6a6bddb67a9cf3690c002818a016450","fff7fbece2f0d0d1e6a6bddb67a9cf3690c002818a016c59014636").map(Xt),V0=xe(G0),H0=new Array(3).concat("ece7f2a6bddb2b8cbe","f1eef6bdc9e174a9cf0570b0","f1eef6bdc9e174a9cf2b8cbe045a8d","f1eef6d0d1e6a6bddb74a9cf2b8cbe045a8d","f1eef6d0d1e6a6bddb74a9cf3690c00570b0034e7b","fff7fbece7f2d0d1e6a6bddb74a9cf3690c00570b0034e7b","fff7fbece7f2d0d1e6a6bddb74a9cf3690c00570b0045a8d023858").map(Xt),W0=xe(H0),$0=new Array(3).concat("e7e1efc994c7dd1c77","f1eef6d7b5d8df65b0ce1256","f1eef6d7b5d8df65b0dd1c77980043","f1eef6d4b9dac994c7df65b0dd1c77980043","f1eef6d4b9dac994c7df65b0e7298ace125691003f","f7f4f9e7e1efd4b9dac994c7df65b0e7298ace125691003f","f7f4f9e7e1efd4b9dac994c7df65b0e7298ace125698004367001f").map(Xt),X0=xe($0),q0=new Array(3).concat("fde0ddfa9fb5c51b8a","feebe2fbb4b9f768a1ae017e","feebe2fbb4b9f768a1c51b8a7a0177","feebe2fcc5c0fa9fb5f768a1c51b8a7a0177","feebe2fcc5c0fa9fb5f768a1dd3497ae017e7a0177","fff7f3fde0ddfcc5c0fa9fb5f768a1dd3497ae017e7a0177","fff7f3fde0ddfcc5c0fa9fb5f768a1dd3497ae017e7a017749006a").map(Xt),Y0=xe(q0),Z0=new Array(3).concat("edf8b17fcdbb2c7fb8","ffffcca1dab441b6c4225ea8","ffffcca1dab441b6c42c7fb8253494","ffffccc7e9b47fcdbb41b6c42c7fb8253494","ffffccc7e9b47fcdbb41b6c41d91c0225ea80c2c84","ffffd9edf8b1c7e9b47fcdbb41b6c41d91c0225ea80c2c84","ffffd9edf8b1c7e9b47fcdbb41b6c41d91c0225ea8253494081d58").map(Xt),J0=xe(Z0),K0=new Array(3).concat("f7fcb9addd8e31a354","ffffccc2e69978c679238443","ffffccc2e69978c67931a354006837","ffffccd9f0a3addd8e78c67931a354006837","ffffccd9f0a3addd8e78c67941ab5d238443005a32","ffffe5f7fcb9d9f0a3addd8e78c67941ab5d238443005a32","ffffe5f7fcb9d9f0a3addd8e78c67941ab5d238443006837004529").map(Xt),j0=xe(K0),Q0=new Array(3).concat("fff7bcfec44fd95f0e","ffffd4fed98efe9929cc4c02","ffffd4fed98efe9929d95f0e993404","ffffd4fee391fec44ffe9929d95f0e993404","ffffd4fee391fec44ffe9929ec7014cc4c028c2d04","ffffe5fff7bcfee391fec44ffe9929ec7014cc4c028c2d04","ffffe5fff7bcfee391fec44ffe9929ec7014cc4c02993404662506").map(Xt),ty=xe(Q0),ey=new Array(3).concat("ffeda0feb24cf03b20","ffffb2fecc5cfd8d3ce31a1c","ffffb2fecc5cfd8d3cf03b20bd0026","ffffb2fed976feb24cfd8d3cf03b20bd0026","ffffb2fed976feb24cfd8d3cfc4e2ae31a1cb10026","ffffccffeda0fed976feb24cfd8d3cfc4e2ae31a1cb10026","ffffccffeda0fed976feb24cfd8d3cfc4e2ae31a1cbd0026800026").map(Xt),ny=xe(ey),iy=new Array(3).concat("deebf79ecae13182bd","eff3ffbdd7e76baed62171b5","eff3ffbdd7e76baed63182bd08519c","eff3ffc6dbef9ecae16baed63182bd08519c","eff3ffc6dbef9ecae16baed64292c62171b5084594","f7fbffdeebf7c6dbef9ecae16baed64292c62171b5084594","f7fbffdeebf7c6dbef9ecae16baed64292c62171b508519c08306b").map(Xt),ry=xe(iy),sy=new Array(3).concat("e5f5e0a1d99b31a354","edf8e9bae4b374c476238b45","edf8e9bae4b374c47631a354006d2c","edf8e9c7e9c0a1d99b74c47631a354006d2c","edf8e9c7e9c0a1d99b74c47641ab5d238b45005a32","f7fcf5e5f5e0c7e9c0a1d99b74c47641ab5d238b45005a32","f7fcf5e5f5e0c7e9c0a1d99b74c47641ab5d238b45006d2c00441b").map(Xt),oy=xe(sy),ay=new Array(3).concat("f0f0f0bdbdbd636363","f7f7f7cccccc969696525252","f7f7f7cccccc969696636363252525","f7f7f7d9d9d9bdbdbd969696636363252525","f7f7f7d9d9d9bdbdbd969696737373525252252525","fffffff0f0f0d9d9d9bdbdbd969696737373525252252525","fffffff0f0f0d9d9d9bdbdbd969696737373525252252525000000").map(Xt),cy=xe(ay),ly=new Array(3).concat("efedf5bcbddc756bb1","f2f0f7cbc9e29e9ac86a51a3","f2f0f7cbc9e29e9ac8756bb154278f","f2f0f7dadaebbcbddc9e9ac8756bb154278f","f2f0f7dadaebbcbddc9e9ac8807dba6a51a34a1486","fcfbfdefedf5dadaebbcbddc9e9ac8807dba6a51a34a1486","fcfbfdefedf5dadaebbcbddc9e9ac8807dba6a51a354278f3f007d").map(Xt),uy=xe(ly),fy=new Array(3).concat("fee0d2fc9272de2d26","fee5d9fcae91fb6a4acb181d","fee5d9fcae91fb6a4ade2d26a50f15","fee5d9fcbba1fc9272fb6a4ade2d26a50f15","fee5d9fcbba1fc9272fb6a4aef3b2ccb181d99000d","fff5f0fee0d2fcbba1fc9272fb6a4aef3b2ccb181d99000d","fff5f0fee0d2fcbba1fc9272fb6a4aef3b2ccb181da50f1567000d").map(Xt),hy=xe(fy),dy=new Array(3).concat("fee6cefdae6be6550d","feeddefdbe85fd8d3cd94701","feeddefdbe85fd8d3ce6550da63603","feeddefdd0a2fdae6bfd8d3ce6550da63603","feeddefdd0a2fdae6bfd8d3cf16913d948018c2d04","fff5ebfee6cefdd0a2fdae6bfd8d3cf16913d948018c2d04","fff5ebfee6cefdd0a2fdae6bfd8d3cf16913d94801a636037f2704").map(Xt),py=xe(dy);function my(e){return e=Math.max(0,Math.min(1,e)),"rgb("+Math.max(0,Math.min(255,Math.round(-4.54-e*(35.34-e*(2381.73-e*(6402.7-e*(7024.72-e*2710.57)))))))+", "+Math.max(0,Math.min(255,Math.round(32.49+e*(170.73+e*(52.82-e*(131.46-e*(176.58-e*67.37)))))))+", "+Math.max(0,Math.min(255,Math.round(81.24+e*(442.36-e*(2482.43-e*(6167.24-e*(6614.94-e*2475.67)))))))+")"}var gy=wh(li(300,.5,0),li(-240,.5,1)),yy=wh(li(-100,.75,.35),li(80,1.5,.8)),xy=wh(li(260,.75,.35),li(80,1.5,.8)),nd=li();function _y(e){(e<0||e>1)&&(e-=Math.floor(e));var t=Math.abs(e-.5);return nd.h=360*e-100,nd.s=1.5-1.5*t,nd.l=.8-.9*t,nd+""}var id=Fi(),P4=Math.PI/3,L4=Math.PI*2/3;function vy(e){var t;return e=(.5-e)*Math.PI,id.r=255*(t=Math.sin(e))*t,id.g=255*(t=Math.sin(e+P4))*t,id.b=255*(t=Math.sin(e+L4))*t,id+""}function by(e){return e=Math.max(0,Math.min(1,e)),"rgb("+Math.max(0,Math.min(255,Math.round(34.61+e*(1172.33-e*(10793.56-e*(33300.12-e*(38394.49-e*14825.05)))))))+", "+Math.max(0,Math.min(255,Math.round(23.31+e*(557.33+e*(1225.33-e*(3574.96-e*(1073.77+e*707.56)))))))+", "+Math.max(0,Math.min(255,Math.round(27.2+e*(3211.1-e*(15327.97-e*(27814-e*(22569.18-e*6838.66)))))))+")"}function od(e){var t=e.length;return function(n){return e[Math.max(0,Math.min(t-1,Math.floor(n*t)))]}}var My=od(Xt("44015444025645045745055946075a46085c460a5d460b5e470d60470e6147106347116447136548146748166848176948186a481a6c481b6d481c6e481d6f481f70482071482173482374482475482576482677482878482979472a7a472c7a472d7b472e7c472f7d46307e46327e46337f463480453581453781453882443983443a83443b84433d84433e85423f854240864241864142874144874045884046883f47883f48893e49893e4a893e4c8a3d4d8a3d4e8a3c4f8a3c508b3b518b3b528b3a538b3a548c39558c39568c38588c38598c375a8c375b8d365c8d365d8d355e8d355f8d34608d34618d33628d33638d32648e32658e31668e31678e31688e30698e306a8e2f6b8e2f6c8e2e6d8e2e6e8e2e6f8e2d708e2d718e2c718e2c728e2c738e2b748e2b758e2a768e2a778e2a788e29798e297a8e297b8e287c8e287d8e277e8e277f8e27808e26818e26828e26828e25838e25848e25858e24868e24878e23888e23898e238a8d228b8d228c8d228d8d218e8d218f8d21908d21918c20928c20928c20938c1f948c1f958b1f968b1f978b1f988b1f998a1f9a8a1e9b8a1e9c891e9d891f9e891f9f881fa0881fa1881fa1871fa28720a38620a48621a58521a68522a78522a88423a98324aa8325ab8225ac8226ad8127ad8128ae8029af7f2ab07f2cb17e2db27d2eb37c2fb47c31b57b32b67a34b67935b77937b87838b9773aba763bbb753dbc743fbc7340bd7242be7144bf7046c06f48c16e4ac16d4cc26c4ec36b50c46a52c56954c56856c66758c7655ac8645cc8635ec96260ca6063cb5f65cb5e67cc5c69cd5b6ccd5a6ece5870cf5773d05675d05477d1537ad1517cd2507fd34e81d34d84d44b86d54989d5488bd6468ed64590d74393d74195d84098d83e9bd93c9dd93ba0da39a2da37a5db36a8db34aadc32addc30b0dd2fb2dd2db5de2bb8de29bade28bddf26c0df25c2df23c5e021c8e020cae11fcde11dd0e11cd2e21bd5e21ad8e219dae319dde318dfe318e2e418e5e419e7e419eae51aece51befe51cf1e51df4e61ef6e620f8e621fbe723fde725")),Sy=od(Xt("00000401000501010601010802010902020b02020d03030f03031204041405041606051806051a07061c08071e0907200a08220b09240c09260d0a290e0b2b100b2d110c2f120d31130d34140e36150e38160f3b180f3d19103f1a10421c10441d11471e114920114b21114e22115024125325125527125829115a2a115c2c115f2d11612f116331116533106734106936106b38106c390f6e3b0f703d0f713f0f72400f74420f75440f764510774710784910784a10794c117a4e117b4f127b51127c52137c54137d56147d57157e59157e5a167e5c167f5d177f5f187f601880621980641a80651a80671b80681c816a1c816b1d816d1d816e1e81701f81721f817320817521817621817822817922827b23827c23827e24828025828125818326818426818627818827818928818b29818c29818e2a81902a81912b81932b80942c80962c80982d80992d809b2e7f9c2e7f9e2f7fa02f7fa1307ea3307ea5317ea6317da8327daa337dab337cad347cae347bb0357bb2357bb3367ab5367ab73779b83779ba3878bc3978bd3977bf3a77c03a76c23b75c43c75c53c74c73d73c83e73ca3e72cc3f71cd4071cf4070d0416fd2426fd3436ed5446dd6456cd8456cd9466bdb476adc4869de4968df4a68e04c67e24d66e34e65e44f64e55064e75263e85362e95462ea5661eb5760ec5860ed5a5fee5b5eef5d5ef05f5ef1605df2625df2645cf3655cf4675cf4695cf56b5cf66c5cf66e5cf7705cf7725cf8745cf8765cf9785df9795df97b5dfa7d5efa7f5efa815ffb835ffb8560fb8761fc8961fc8a62fc8c63fc8e64fc9065fd9266fd9467fd9668fd9869fd9a6afd9b6bfe9d6cfe9f6dfea16efea36ffea571fea772fea973feaa74feac76feae77feb078feb27afeb47bfeb67cfeb77efeb97ffebb81febd82febf84fec185fec287fec488fec68afec88cfeca8dfecc8ffecd90fecf92fed194fed395fed597fed799fed89afdda9cfddc9efddea0fde0a1fde2a3fde3a5fde5a7fde7a9fde9aafdebacfcecaefceeb0fcf0b2fcf2b4fcf4b6fcf6b8fcf7b9fcf9bbfcfbbdfcfdbf")),wy=od(Xt("00000401000501010601010802010a02020c02020e03021004031204031405041706041907051b08051d09061f0a07220b07240c08260d08290e092b10092d110a30120a32140b34150b37160b39180c3c190c3e1b0c411c0c431e0c451f0c48210c4a230c4c240c4f260c51280b53290b552b0b572d0b592f0a5b310a5c320a5e340a5f3609613809623909633b09643d09653e0966400a67420a68440a68450a69470b6a490b6a4a0c6b4c0c6b4d0d6c4f0d6c510e6c520e6d540f6d550f6d57106e59106e5a116e5c126e5d126e5f136e61136e62146e64156e65156e67166e69166e6a176e6c186e6d186e6f196e71196e721a6e741a6e751b6e771c6d781c6d7a1d6d7c1d6d7d1e6d7f1e6c801f6c82206c84206b85216b87216b88226a8a226a8c23698d23698f24699025689225689326679526679727669827669a28659b29649d29649f2a63a02a63a22b62a32c61a52c60a62d60a82e5fa92e5eab2f5ead305dae305cb0315bb1325ab3325ab43359b63458b73557b93556ba3655bc3754bd3853bf3952c03a51c13a50c33b4fc43c4ec63d4dc73e4cc83f4bca404acb4149cc4248ce4347cf4446d04545d24644d34743d44842d54a41d74b3fd84c3ed94d3dda4e3cdb503bdd513ade5238df5337e05536e15635e25734e35933e45a31e55c30e65d2fe75e2ee8602de9612bea632aeb6429eb6628ec6726ed6925ee6a24ef6c23ef6e21f06f20f1711ff1731df2741cf3761bf37819f47918f57b17f57d15f67e14f68013f78212f78410f8850ff8870ef8890cf98b0bf98c0af98e09fa9008fa9207fa9407fb9606fb9706fb9906fb9b06fb9d07fc9f07fca108fca309fca50afca60cfca80dfcaa0ffcac11fcae12fcb014fcb216fcb418fbb61afbb81dfbba1ffbbc21fbbe23fac026fac228fac42afac62df9c72ff9c932f9cb35f8cd37f8cf3af7d13df7d340f6d543f6d746f5d949f5db4cf4dd4ff4df53f4e156f3e35af3e55df2e661f2e865f2ea69f1ec6df1ed71f1ef75f1f179f2f27df2f482f3f586f3f68af4f88ef5f992f6fa96f8fb9af9fc9dfafda1fcffa4")),Ty=od(Xt("0d088710078813078916078a19068c1b068d1d068e20068f2206902406912605912805922a05932c05942e05952f059631059733059735049837049938049a3a049a3c049b3e049c3f049c41049d43039e44039e46039f48039f4903a04b03a14c02a14e02a25002a25102a35302a35502a45601a45801a45901a55b01a55c01a65e01a66001a66100a76300a76400a76600a76700a86900a86a00a86c00a86e00a86f00a87100a87201a87401a87501a87701a87801a87a02a87b02a87d03a87e03a88004a88104a78305a78405a78606a68707a68808a68a09a58b0aa58d0ba58e0ca48f0da4910ea3920fa39410a29511a19613a19814a099159f9a169f9c179e9d189d9e199da01a9ca11b9ba21d9aa31e9aa51f99a62098a72197a82296aa2395ab2494ac2694ad2793ae2892b02991b12a90b22b8fb32c8eb42e8db52f8cb6308bb7318ab83289ba3388bb3488bc3587bd3786be3885bf3984c03a83c13b82c23c81c33d80c43e7fc5407ec6417dc7427cc8437bc9447aca457acb4679cc4778cc4977cd4a76ce4b75cf4c74d04d73d14e72d24f71d35171d45270d5536fd5546ed6556dd7566cd8576bd9586ada5a6ada5b69db5c68dc5d67dd5e66de5f65de6164df6263e06363e16462e26561e26660e3685fe4695ee56a5de56b5de66c5ce76e5be76f5ae87059e97158e97257ea7457eb7556eb7655ec7754ed7953ed7a52ee7b51ef7c51ef7e50f07f4ff0804ef1814df1834cf2844bf3854bf3874af48849f48948f58b47f58c46f68d45f68f44f79044f79143f79342f89441f89540f9973ff9983ef99a3efa9b3dfa9c3cfa9e3bfb9f3afba139fba238fca338fca537fca636fca835fca934fdab33fdac33fdae32fdaf31fdb130fdb22ffdb42ffdb52efeb72dfeb82cfeba2cfebb2bfebd2afebe2afec029fdc229fdc328fdc527fdc627fdc827fdca26fdcb26fccd25fcce25fcd025fcd225fbd324fbd524fbd724fad824fada24f9dc24f9dd25f8df25f8e125f7e225f7e425f6e626f6e826f5e926f5eb27f4ed27f3ee27f3f027f2f227f1f426f1f525f0f724f0f921"));function nn(e){return function(){return e}}var Hw=Math.cos;var Ry=Math.min,ad=Math.sin,$e=Math.sqrt,Bw=1e-12,Ll=Math.PI,IV=Ll/2,hd=2*Ll;function Ww(e){let t=3;return e.digits=function(n){if(!arguments.length)return t;if(n==null)t=null;else{let i=Math.floor(n);if(!(i>=0))throw new RangeError(`invalid digits: ${n}`);t=i}return e},()=>new ao(t)}var PV=Array.prototype.slice;function $w(e){return typeof e=="object"&&"length"in e?e:Array.from(e)}function Xw(e){this._context=e}Xw.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._point=0},lineEnd:function(){(this._line||this._line!==0&&this._point===1)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1,this._line?this._context.lineTo(e,t):this._context.moveTo(e,t);break;case 1:this._point=2;default:this._context.lineTo(e,t);break}}};function vo(e){return new Xw(e)}function qw(e){return e[0]}function Yw(e){return e[1]}function Iy(e,t){var n=nn(!0),i=null,r=vo,s=null,o=Ww(a);e=typeof e=="function"?e:e===void 0?qw:nn(e),t=typeof t=="function"?t:t===void 0?Yw:nn(t);function a(c){var l,u=(c=$w(c)).length,h,f=!1,d;for(i==null&&(s=r(d=o())),l=0;l<=u;++l)!(l<u&&n(h=c[l],l,c))===f&&((f=!f)?s.lineStart():s.lineEnd()),f&&s.point(+e(h,l,c),+t(h,l,c));if(d)return s=null,d+""||null}return a.x=function(c){return arguments.length?(e=typeof c=="function"?c:nn(+c),a):e},a.y=function(c){return arguments.length?(t=typeof c=="function"?c:nn(+c),a):t},a.defined=function(c){return arguments.length?(n=typeof c=="function"?c:nn(!!c),a):n},a.curve=function(c){return arguments.length?(r=c,i!=null&&(s=r(i)),a):r},a.context=function(c){return arguments.length?(c==null?i=s=null:s=r(i=c),a):i},a}function Zw(e,t,n){var i=null,r=nn(!0),s=null,o=vo,a=null,c=Ww(l);e=typeof e=="function"?e:e===void 0?qw:nn(+e),t=typeof t=="function"?t:nn(t===void 0?0:+t),n=typeof n=="function"?n:n===void 0?Yw:nn(+n);function l(h){var f,d,p,y=(h=$w(h)).length,m,g=!1,v,S=new Array(y),_=new Array(y);for(s==null&&(a=o(v=c())),f=0;f<=y;++f){if(!(f<y&&r(m=h[f],f,h))===g)if(g=!g)d=f,a.areaStart(),a.lineStart();else{for(a.lineEnd(),a.lineStart(),p=f-1;p>=d;--p)a.point(S[p],_[p]);a.lineEnd(),a.areaEnd()}g&&(S[f]=+e(m,f,h),_[f]=+t(m,f,h),a.point(i?+i(m,f,h):S[f],n?+n(m,f,h):_[f]))}if(v)return a=null,v+""||null}function u(){return Iy().defined(r).curve(o).context(s)}return l.x=function(h){return arguments.length?(e=typeof h=="function"?h:nn(+h),i=null,l):e},l.x0=function(h){return arguments.length?(e=typeof h=="function"?h:nn(+h),l):e},l.x1=function(h){return arguments.length?(i=h==null?null:typeof h=="function"?h:nn(+h),l):i},l.y=function(h){return arguments.length?(t=typeof h=="function"?h:nn(+h),n=null,l):t},l.y0=function(h){return arguments.length?(t=typeof h=="function"?h:nn(+h),l):t},l.y1=function(h){return arguments.length?(n=h==null?null:typeof h=="function"?h:nn(+h),l):n},l.lineX0=l.lineY0=function(){return u().x(e).y(t)},l.lineY1=function(){return u().x(e).y(n)},l.lineX1=function(){return u().x(i).y(t)},l.defined=function(h){return arguments.length?(r=typeof h=="function"?h:nn(!!h),l):r},l.curve=function(h){return arguments.length?(o=h,s!=null&&(a=o(s)),l):o},l.context=function(h){return arguments.length?(h==null?s=a=null:a=o(s=h),l):s},l}var LV=N4(vo);function Jw(e){this._curve=e}Jw.prototype={areaStart:function(){this._curve.areaStart()},areaEnd:function(){this._curve.areaEnd()},lineStart:function(){this._curve.lineStart()},lineEnd:function(){this._curve.lineEnd()},point:function(e,t){this._curve.point(t*Math.sin(e),t*-Math.cos(e))}};function N4(e){function t(n){return new Jw(e(n))}return t._curve=e,t}var cd=class{constructor(t,n){this._context=t,this._x=n}areaStart(){this._line=0}areaEnd(){this._line=NaN}lineStart(){this._point=0}lineEnd(){(this._line||this._line!==0&&this._point===1)&&this._context.closePath(),this._line=1-this._line}point(t,n){switch(t=+t,n=+n,this._point){case 0:{this._point=1,this._line?this._context.lineTo(t,n):this._context.moveTo(t,n);break}case 1:this._point=2;default:{this._x?this._context.bezierCurveTo(this._x0=(this._x0+t)/2,this._y0,this._x0,n,t,n):this._context.bezierCurveTo(this._x0,this._y0=(this._y0+n)/2,t,this._y0,t,n);break}}this._x0=t,this._y0=n}};function Kw(e){return new cd(e,!0)}function jw(e){return new cd(e,!1)}var D4=$e(3),Py={draw(e,t){let n=$e(t+Ry(t/28,.75))*.59436,i=n/2,r=i*D4;e.moveTo(0,n),e.lineTo(0,-n),e.moveTo(-r,-i),e.lineTo(r,i),e.moveTo(-r,i),e.lineTo(r,-i)}},bo={draw(e,t){let n=$e(t/Ll);e.moveTo(n,0),e.arc(0,0,n,0,hd)}},Ly={draw(e,t){let n=$e(t/5)/2;e.moveTo(-3*n,-n),e.lineTo(-n,-n),e.lineTo(-n,-3*n),e.lineTo(n,-3*n),e.lineTo(n,-n),e.lineTo(3*n,-n),e.lineTo(3*n,n),e.lineTo(n,n),e.lineTo(n,3*n),e.lineTo(-n,3*n),e.lineTo(-n,n),e.lineTo(-3*n,n),e.closePath()}},Qw=$e(1/3),F4=Qw*2,Ny={draw(e,t){let n=$e(t/F4),i=n*Qw;e.moveTo(0,-n),e.lineTo(i,0),e.lineTo(0,n),e.lineTo(-i,0),e.closePath()}},Dy={draw(e,t){let n=$e(t)*.62625;e.moveTo(0,-n),e.lineTo(n,0),e.lineTo(0,n),e.lineTo(-n,0),e.closePath()}},Fy={draw(e,t){let n=$e(t-Ry(t/7,2))*.87559;e.moveTo(-n,0),e.lineTo(n,0),e.moveTo(0,n),e.lineTo(0,-n)}},Uy={draw(e,t){let n=$e(t),i=-n/2;e.rect(i,i,n,n)}},Oy={draw(e,t){let n=$e(t)*.4431;e.moveTo(n,n),e.lineTo(n,-n),e.lineTo(-n,-n),e.lineTo(-n,n),e.closePath()}},U4=.8908130915292852,tT=ad(Ll/10)/ad(7*Ll/10),O4=ad(hd/10)*tT,B4=-Hw(hd/10)*tT,By={draw(e,t){let n=$e(t*U4),i=O4*n,r=B4*n;e.moveTo(0,-n),e.lineTo(i,r);for(let s=1;s<5;++s){let o=hd*s/5,a=Hw(o),c=ad(o);e.lineTo(c*n,-a*n),e.lineTo(a*i-c*r,c*i+a*r)}e.closePath()}},Ay=$e(3),ky={draw(e,t){let n=-$e(t/(Ay*3));e.moveTo(0,n*2),e.lineTo(-Ay*n,-n),e.lineTo(Ay*n,-n),e.closePath()}},k4=$e(3),zy={draw(e,t){let n=$e(t)*.6824,i=n/2,r=n*k4/2;e.moveTo(0,-n),e.lineTo(r,i),e.lineTo(-r,i),e.closePath()}},gi=-.5,yi=$e(3)/2,Cy=1/$e(12),z4=(Cy/2+1)*3,Gy={draw(e,t){let n=$e(t/z4),i=n/2,r=n*Cy,s=i,o=n*Cy+n,a=-s,c=o;e.moveTo(i,r),e.lineTo(s,o),e.lineTo(a,c),e.lineTo(gi*i-yi*r,yi*i+gi*r),e.lineTo(gi*s-yi*o,yi*s+gi*o),e.lineTo(gi*a-yi*c,yi*a+gi*c),e.lineTo(gi*i+yi*r,gi*r-yi*i),e.lineTo(gi*s+yi*o,gi*o-yi*s),e.lineTo(gi*a+yi*c,gi*c-yi*a),e.closePath()}},Vy={draw(e,t){let n=$e(t-Ry(t/6,1.7))*.6189;e.moveTo(-n,-n),e.lineTo(n,n),e.moveTo(-n,n),e.lineTo(n,-n)}},eT=[bo,Ly,Ny,Uy,By,ky,Gy],nT=[bo,Fy,Vy,zy,Py,Oy,Dy];function Ts(){}function ld(e,t,n){e._context.bezierCurveTo((2*e._x0+e._x1)/3,(2*e._y0+e._y1)/3,(e._x0+2*e._x1)/3,(e._y0+2*e._y1)/3,(e._x0+4*e._x1+t)/6,(e._y0+4*e._y1+n)/6)}function dd(e){this._context=e}dd.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x0=this._x1=this._y0=this._y1=NaN,this._point=0},lineEnd:function(){switch(this._point){case 3:ld(this,this._x1,this._y1);case 2:this._context.lineTo(this._x1,this._y1);break}(this._line||this._line!==0&&this._point===1)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1,this._line?this._context.lineTo(e,t):this._context.moveTo(e,t);break;case 1:this._point=2;break;case 2:this._point=3,this._context.lineTo((5*this._x0+this._x1)/6,(5*this._y0+this._y1)/6);default:ld(this,e,t);break}this._x0=this._x1,this._x1=e,this._y0=this._y1,this._y1=t}};function iT(e){return new dd(e)}function rT(e){this._context=e}rT.prototype={areaStart:Ts,areaEnd:Ts,lineStart:function(){this._x0=this._x1=this._x2=this._x3=this._x4=this._y0=this._y1=this._y2=this._y3=this._y4=NaN,this._point=0},lineEnd:function(){switch(this._point){case 1:{this._context.moveTo(this._x2,this._y2),this._context.closePath();break}case 2:{this._context.moveTo((this._x2+2*this._x3)/3,(this._y2+2*this._y3)/3),this._context.lineTo((this._x3+2*this._x2)/3,(this._y3+2*this._y2)/3),this._context.closePath();break}case 3:{this.point(this._x2,this._y2),this.point(this._x3,this._y3),this.point(this._x4,this._y4);break}}},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1,this._x2=e,this._y2=t;break;case 1:this._point=2,this._x3=e,this._y3=t;break;case 2:this._point=3,this._x4=e,this._y4=t,this._context.moveTo((this._x0+4*this._x1+e)/6,(this._y0+4*this._y1+t)/6);break;default:ld(this,e,t);break}this._x0=this._x1,this._x1=e,this._y0=this._y1,this._y1=t}};function sT(e){return new rT(e)}function oT(e){this._context=e}oT.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x0=this._x1=this._y0=this._y1=NaN,this._point=0},lineEnd:function(){(this._line||this._line!==0&&this._point===3)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1;break;case 1:this._point=2;break;case 2:this._point=3;var n=(this._x0+4*this._x1+e)/6,i=(this._y0+4*this._y1+t)/6;this._line?this._context.lineTo(n,i):this._context.moveTo(n,i);break;case 3:this._point=4;default:ld(this,e,t);break}this._x0=this._x1,this._x1=e,this._y0=this._y1,this._y1=t}};function aT(e){return new oT(e)}function cT(e,t){this._basis=new dd(e),this._beta=t}cT.prototype={lineStart:function(){this._x=[],this._y=[],this._basis.lineStart()},lineEnd:function(){var e=this._x,t=this._y,n=e.length-1;if(n>0)for(var i=e[0],r=t[0],s=e[n]-i,o=t[n]-r,a=-1,c;++a<=n;)c=a/n,this._basis.point(this._beta*e[a]+(1-this._beta)*(i+c*s),this._beta*t[a]+(1-this._beta)*(r+c*o));this._x=this._y=null,this._basis.lineEnd()},point:function(e,t){this._x.push(+e),this._y.push(+t)}};var lT=(function e(t){function n(i){return t===1?new dd(i):new cT(i,t)}return n.beta=function(i){return e(+i)},n})(.85);function ud(e,t,n){e._context.bezierCurveTo(e._x1+e._k*(e._x2-e._x0),e._y1+e._k*(e._y2-e._y0),e._x2+e._k*(e._x1-t),e._y2+e._k*(e._y1-n),e._x2,e._y2)}function Hy(e,t){this._context=e,this._k=(1-t)/6}Hy.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x0=this._x1=this._x2=this._y0=this._y1=this._y2=NaN,this._point=0},lineEnd:function(){switch(this._point){case 2:this._context.lineTo(this._x2,this._y2);break;case 3:ud(this,this._x1,this._y1);break}(this._line||this._line!==0&&this._point===1)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1,this._line?this._context.lineTo(e,t):this._context.moveTo(e,t);break;case 1:this._point=2,this._x1=e,this._y1=t;break;case 2:this._point=3;default:ud(this,e,t);break}this._x0=this._x1,this._x1=this._x2,this._x2=e,this._y0=this._y1,this._y1=this._y2,this._y2=t}};var uT=(function e(t){function n(i){return new Hy(i,t)}return n.tension=function(i){return e(+i)},n})(0);function Wy(e,t){this._context=e,this._k=(1-t)/6}Wy.prototype={areaStart:Ts,areaEnd:Ts,lineStart:function(){this._x0=this._x1=this._x2=this._x3=this._x4=this._x5=this._y0=this._y1=this._y2=this._y3=this._y4=this._y5=NaN,this._point=0},lineEnd:function(){switch(this._point){case 1:{this._context.moveTo(this._x3,this._y3),this._context.closePath();break}case 2:{this._context.lineTo(this._x3,this._y3),this._context.closePath();break}case 3:{this.point(this._x3,this._y3),this.point(this._x4,this._y4),this.point(this._x5,this._y5);break}}},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1,this._x3=e,this._y3=t;break;case 1:this._point=2,this._context.moveTo(this._x4=e,this._y4=t);break;case 2:this._point=3,this._x5=e,this._y5=t;break;default:ud(this,e,t);break}this._x0=this._x1,this._x1=this._x2,this._x2=e,this._y0=this._y1,this._y1=this._y2,this._y2=t}};var fT=(function e(t){function n(i){return new Wy(i,t)}return n.tension=function(i){return e(+i)},n})(0);function $y(e,t){this._context=e,this._k=(1-t)/6}$y.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x0=this._x1=this._x2=this._y0=this._y1=this._y2=NaN,this._point=0},lineEnd:function(){(this._line||this._line!==0&&this._point===3)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1;break;case 1:this._point=2;break;case 2:this._point=3,this._line?this._context.lineTo(this._x2,this._y2):this._context.moveTo(this._x2,this._y2);break;case 3:this._point=4;default:ud(this,e,t);break}this._x0=this._x1,this._x1=this._x2,this._x2=e,this._y0=this._y1,this._y1=this._y2,this._y2=t}};var hT=(function e(t){function n(i){return new $y(i,t)}return n.tension=function(i){return e(+i)},n})(0);function Xy(e,t,n){var i=e._x1,r=e._y1,s=e._x2,o=e._y2;if(e._l01_a>Bw){var a=2*e._l01_2a+3*e._l01_a*e._l12_a+e._l12_2a,c=3*e._l01_a*(e._l01_a+e._l12_a);i=(i*a-e._x0*e._l12_2a+e._x2*e._l01_2a)/c,r=(r*a-e._y0*e._l12_2a+e._y2*e._l01_2a)/c}if(e._l23_a>Bw){var l=2*e._l23_2a+3*e._l23_a*e._l12_a+e._l12_2a,u=3*e._l23_a*(e._l23_a+e._l12_a);s=(s*l+e._x1*e._l23_2a-t*e._l12_2a)/u,o=(o*l+e._y1*e._l23_2a-n*e._l12_2a)/u}e._context.bezierCurveTo(i,r,s,o,e._x2,e._y2)}function dT(e,t){this._context=e,this._alpha=t}dT.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x0=this._x1=this._x2=this._y0=this._y1=this._y2=NaN,this._l01_a=this._l12_a=this._l23_a=this._l01_2a=this._l12_2a=this._l23_2a=this._point=0},lineEnd:function(){switch(this._point){case 2:this._context.lineTo(this._x2,this._y2);break;case 3:this.point(this._x2,this._y2);break}(this._line||this._line!==0&&this._point===1)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){if(e=+e,t=+t,this._point){var n=this._x2-e,i=this._y2-t;this._l23_a=Math.sqrt(this._l23_2a=Math.pow(n*n+i*i,this._alpha))}switch(this._point){case 0:this._point=1,this._line?this._context.lineTo(e,t):this._context.moveTo(e,t);break;case 1:this._point=2;break;case 2:this._point=3;default:Xy(this,e,t);break}this._l01_a=this._l12_a,this._l12_a=this._l23_a,this._l01_2a=this._l12_2a,this._l12_2a=this._l23_2a,this._x0=this._x1,this._x1=this._x2,this._x2=e,this._y0=this._y1,this._y1=this._y2,this._y2=t}};var pT=(function e(t){function n(i){return t?new dT(i,t):new Hy(i,0)}return n.alpha=function(i){return e(+i)},n})(.5);function mT(e,t){this._context=e,this._alpha=t}mT.prototype={areaStart:Ts,areaEnd:Ts,lineStart:function(){this._x0=this._x1=this._x2=this._x3=this._x4=this._x5=this._y0=this._y1=this._y2=this._y3=this._y4=this._y5=NaN,this._l01_a=this._l12_a=this._l23_a=this._l01_2a=this._l12_2a=this._l23_2a=this._point=0},lineEnd:function(){switch(this._point){case 1:{this._context.moveTo(this._x3,this._y3),this._context.closePath();break}case 2:{this._context.lineTo(this._x3,this._y3),this._context.closePath();break}case 3:{this.point(this._x3,this._y3),this.point(this._x4,this._y4),this.point(this._x5,this._y5);break}}},point:function(e,t){if(e=+e,t=+t,this._point){var n=this._x2-e,i=this._y2-t;this._l23_a=Math.sqrt(this._l23_2a=Math.pow(n*n+i*i,this._alpha))}switch(this._point){case 0:this._point=1,this._x3=e,this._y3=t;break;case 1:this._point=2,this._context.moveTo(this._x4=e,this._y4=t);break;case 2:this._point=3,this._x5=e,this._y5=t;break;default:Xy(this,e,t);break}this._l01_a=this._l12_a,this._l12_a=this._l23_a,this._l01_2a=this._l12_2a,this._l12_2a=this._l23_2a,this._x0=this._x1,this._x1=this._x2,this._x2=e,this._y0=this._y1,this._y1=this._y2,this._y2=t}};var gT=(function e(t){function n(i){return t?new mT(i,t):new Wy(i,0)}return n.alpha=function(i){return e(+i)},n})(.5);function yT(e,t){this._context=e,this._alpha=t}yT.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x0=this._x1=this._x2=this._y0=this._y1=this._y2=NaN,this._l01_a=this._l12_a=this._l23_a=this._l01_2a=this._l12_2a=this._l23_2a=this._point=0},lineEnd:function(){(this._line||this._line!==0&&this._point===3)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){if(e=+e,t=+t,this._point){var n=this._x2-e,i=this._y2-t;this._l23_a=Math.sqrt(this._l23_2a=Math.pow(n*n+i*i,this._alpha))}switch(this._point){case 0:this._point=1;break;case 1:this._point=2;break;case 2:this._point=3,this._line?this._context.lineTo(this._x2,this._y2):this._context.moveTo(this._x2,this._y2);break;case 3:this._point=4;default:Xy(this,e,t);break}this._l01_a=this._l12_a,this._l12_a=this._l23_a,this._l01_2a=this._l12_2a,this._l12_2a=this._l23_2a,this._x0=this._x1,this._x1=this._x2,this._x2=e,this._y0=this._y1,this._y1=this._y2,this._y2=t}};var xT=(function e(t){function n(i){return t?new yT(i,t):new $y(i,0)}return n.alpha=function(i){return e(+i)},n})(.5);function _T(e){this._context=e}_T.prototype={areaStart:Ts,areaEnd:Ts,lineStart:function(){this._point=0},lineEnd:function(){this._point&&this._context.closePath()},point:function(e,t){e=+e,t=+t,this._point?this._context.lineTo(e,t):(this._point=1,this._context.moveTo(e,t))}};function vT(e){return new _T(e)}function kw(e){return e<0?-1:1}function zw(e,t,n){var i=e._x1-e._x0,r=t-e._x1,s=(e._y1-e._y0)/(i||r<0&&-0),o=(n-e._y1)/(r||i<0&&-0),a=(s*r+o*i)/(i+r);return(kw(s)+kw(o))*Math.min(Math.abs(s),Math.abs(o),.5*Math.abs(a))||0}function Gw(e,t){var n=e._x1-e._x0;return n?(3*(e._y1-e._y0)/n-t)/2:t}function Ey(e,t,n){var i=e._x0,r=e._y0,s=e._x1,o=e._y1,a=(s-i)/3;e._context.bezierCurveTo(i+a,r+a*t,s-a,o-a*n,s,o)}function fd(e){this._context=e}fd.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x0=this._x1=this._y0=this._y1=this._t0=NaN,this._point=0},lineEnd:function(){switch(this._point){case 2:this._context.lineTo(this._x1,this._y1);break;case 3:Ey(this,this._t0,Gw(this,this._t0));break}(this._line||this._line!==0&&this._point===1)&&this._context.closePath(),this._line=1-this._line},point:function(e,t){var n=NaN;if(e=+e,t=+t,!(e===this._x1&&t===this._y1)){switch(this._point){case 0:this._point=1,this._line?this._context.lineTo(e,t):this._context.moveTo(e,t);break;case 1:this._point=2;break;case 2:this._point=3,Ey(this,Gw(this,n=zw(this,e,t)),n);break;default:Ey(this,this._t0,n=zw(this,e,t));break}this._x0=this._x1,this._x1=e,this._y0=this._y1,this._y1=t,this._t0=n}}};function bT(e){this._context=new MT(e)}(bT.prototype=Object.create(fd.prototype)).point=function(e,t){fd.prototype.point.call(this,t,e)};function MT(e){this._context=e}MT.prototype={moveTo:function(e,t){this._context.moveTo(t,e)},closePath:function(){this._context.closePath()},lineTo:function(e,t){this._context.lineTo(t,e)},bezierCurveTo:function(e,t,n,i,r,s){this._context.bezierCurveTo(t,e,i,n,s,r)}};function ST(e){return new fd(e)}function wT(e){return new bT(e)}function TT(e){this._context=e}TT.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x=[],this._y=[]},lineEnd:function(){var e=this._x,t=this._y,n=e.length;if(n)if(this._line?this._context.lineTo(e[0],t[0]):this._context.moveTo(e[0],t[0]),n===2)this._context.lineTo(e[1],t[1]);else for(var i=Vw(e),r=Vw(t),s=0,o=1;o<n;++s,++o)this._context.bezierCurveTo(i[0][s],r[0][s],i[1][s],r[1][s],e[o],t[o]);(this._line||this._line!==0&&n===1)&&this._context.closePath(),this._line=1-this._line,this._x=this._y=null},point:function(e,t){this._x.push(+e),this._y.push(+t)}};function Vw(e){var t,n=e.length-1,i,r=new Array(n),s=new Array(n),o=new Array(n);for(r[0]=0,s[0]=2,o[0]=e[0]+2*e[1],t=1;t<n-1;++t)r[t]=1,s[t]=4,o[t]=4*e[t]+2*e[t+1];for(r[n-1]=2,s[n-1]=7,o[n-1]=8*e[n-1]+e[n],t=1;t<n;++t)i=r[t]/s[t-1],s[t]-=i,o[t]-=i*o[t-1];for(r[n-1]=o[n-1]/s[n-1],t=n-2;t>=0;--t)r[t]=(o[t]-r[t+1])/s[t];for(s[n-1]=(e[n]+r[n-1])/2,t=0;t<n-1;++t)s[t]=2*e[t+1]-r[t+1];return[r,s]}function AT(e){return new TT(e)}function pd(e,t){this._context=e,this._t=t}pd.prototype={areaStart:function(){this._line=0},areaEnd:function(){this._line=NaN},lineStart:function(){this._x=this._y=NaN,this._point=0},lineEnd:function(){0<this._t&&this._t<1&&this._point===2&&this._context.lineTo(this._x,this._y),(this._line||this._line!==0&&this._point===1)&&this._context.closePath(),this._line>=0&&(this._t=1-this._t,this._line=1-this._line)},point:function(e,t){switch(e=+e,t=+t,this._point){case 0:this._point=1,this._line?this._context.lineTo(e,t):this._context.moveTo(e,t);break;case 1:this._point=2;default:{if(this._t<=0)this._context.lineTo(this._x,t),this._context.lineTo(e,t);else{var n=this._x*(1-this._t)+e*this._t;this._context.lineTo(n,this._y),this._context.lineTo(n,t)}break}}this._x=e,this._y=t}};function ET(e){return new pd(e,.5)}function CT(e){return new pd(e,0)}function RT(e){return new pd(e,1)}function xi(e){return e!=null&&!Number.isNaN(e)}function yn(e,t){return+xi(t)-+xi(e)||gn(e,t)}function Mo(e,t){return+xi(t)-+xi(e)||Or(e,t)}function Nl(e){return e!=null&&`${e}`!=""}function qy(e){return isFinite(e)?e:NaN}function So(e){return e>0&&isFinite(e)?e:NaN}function Da(e){return e<0&&isFinite(e)?e:NaN}function md(e,t){if(e instanceof Date||(e=new Date(+e)),isNaN(e))return typeof t=="function"?t(e):t;let n=e.getUTCHours(),i=e.getUTCMinutes(),r=e.getUTCSeconds(),s=e.getUTCMilliseconds();return`${G4(e.getUTCFullYear(),4)}-${qr(e.getUTCMonth()+1,2)}-${qr(e.getUTCDate(),2)}${n||i||r||s?`T${qr(n,2)}:${qr(i,2)}${r||s?`:${qr(r,2)}${s?`.${qr(s,3)}`:""}`:""}Z`:""}`}function G4(e){return e<0?`-${qr(-e,6)}`:e>9999?`+${qr(e,6)}`:qr(e,4)}function qr(e,t){return`${e}`.padStart(t,"0")}var V4=/^(?:[-+]\d{2})?\d{4}(?:-\d{2}(?:-\d{2})?)?(?:T\d{2}:\d{2}(?::\d{2}(?:\.\d{3})?)?(?:Z|[-+]\d{2}:?\d{2})?)?$/;function Dl(e,t){return V4.test(e+="")?new Date(e):typeof t=="function"?t(e):t}function Yr(e){if(e==null)return;let t=e[0],n=e[e.length-1];return Or(t,n)}var Ua=1e3,Es=Ua*60,Cs=Es*60,fr=Cs*24,ur=fr*7,wo=fr*30,As=fr*365,Yy=[["millisecond",1],["2 milliseconds",2],["5 milliseconds",5],["10 milliseconds",10],["20 milliseconds",20],["50 milliseconds",50],["100 milliseconds",100],["200 milliseconds",200],["500 milliseconds",500],["second",Ua],["5 seconds",5*Ua],["15 seconds",15*Ua],["30 seconds",30*Ua],["minute",Es],["5 minutes",5*Es],["15 minutes",15*Es],["30 minutes",30*Es],["hour",Cs],["3 hours",3*Cs],["6 hours",6*Cs],["12 hours",12*Cs],["day",fr],["2 days",2*fr],["week",ur],["2 weeks",2*ur],["month",wo],["3 months",3*wo],["6 months",6*wo],["year",As],["2 years",2*As],["5 years",5*As],["10 years",10*As],["20 years",20*As],["50 years",50*As],["100 years",100*As]],Zy=new Map([["second",Ua],["minute",Es],["hour",Cs],["day",fr],["monday",ur],["tuesday",ur],["wednesday",ur],["thursday",ur],["friday",ur],["saturday",ur],["sunday",ur],["week",ur],["month",wo],["year",As]]),PT=new Map([["second",Rn],["minute",lo],["hour",fo],["day",sr],["monday",mo],["tuesday",Jg],["wednesday",Kg],["thursday",$r],["friday",jg],["saturday",Qg],["sunday",or],["week",or],["month",xo],["year",kn]]),Jy=new Map([["second",Rn],["minute",uo],["hour",ho],["day",Ml],["monday",yo],["tuesday",t0],["wednesday",e0],["thursday",Xr],["friday",n0],["saturday",i0],["sunday",ar],["week",ar],["month",_o],["year",zn]]),Oa=Symbol("intervalDuration"),yd=Symbol("intervalType");for(let[e,t]of PT)t[Oa]=Zy.get(e),t[yd]="time";for(let[e,t]of Jy)t[Oa]=Zy.get(e),t[yd]="utc";var Fl=[["year",zn,"utc"],["month",_o,"utc"],["day",Ml,"utc",6*wo],["hour",ho,"utc",3*fr],["minute",uo,"utc",6*Cs],["second",Rn,"utc",30*Es]],gd=[["year",kn,"time"],["month",xo,"time"],["day",sr,"time",6*wo],["hour",fo,"time",3*fr],["minute",lo,"time",6*Cs],["second",Rn,"time",30*Es]],H4=[Fl[0],gd[0],Fl[1],gd[1],Fl[2],gd[2],...Fl.slice(3)];function LT(e){let t=`${e}`.toLowerCase();t.endsWith("s")&&(t=t.slice(0,-1));let n=1,i=/^(?:(\d+)\s+)/.exec(t);switch(i&&(t=t.slice(i[0].length),n=+i[1]),t){case"quarter":t="month",n*=3;break;case"half":t="month",n*=6;break}let r=Jy.get(t);if(!r)throw new Error(`unknown interval: ${e}`);if(n>1&&!r.every)throw new Error(`non-periodic interval: ${t}`);return[t,n]}function Ky(e){return NT(LT(e),"time")}function Ul(e){return NT(LT(e),"utc")}function NT([e,t],n){let i=(n==="time"?PT:Jy).get(e);return t>1&&(i=i.every(t),i[Oa]=Zy.get(e)*t,i[yd]=n),i}function jy(e,t){if(!(t>1))return;let n=e[Oa];if(!Yy.some(([,r])=>r===n)||n%fr===0&&fr<n&&n<wo)return;let[i]=Yy[pa(([,r])=>Math.log(r)).center(Yy,Math.log(n*t))];return(e[yd]==="time"?Ky:Ul)(i)}function IT(e,t,n){let i=t==="time"?Al:cr;if(n==null)return i(e==="year"?"%Y":e==="month"?"%Y-%m":e==="day"?"%Y-%m-%d":e==="hour"||e==="minute"?"%Y-%m-%dT%H:%M":e==="second"?"%Y-%m-%dT%H:%M:%S":"%Y-%m-%dT%H:%M:%S.%L");let r=W4(n);switch(e){case"millisecond":return Fa(i(".%L"),i(":%M:%S"),r);case"second":return Fa(i(":%S"),i("%-I:%M"),r);case"minute":return Fa(i("%-I:%M"),i("%p"),r);case"hour":return Fa(i("%-I %p"),i("%b %-d"),r);case"day":return Fa(i("%-d"),i("%b"),r);case"month":return Fa(i("%b"),i("%Y"),r);case"year":return i("%Y")}throw new Error("unable to format time ticks")}function W4(e){return e==="left"||e==="right"?(t,n)=>`
${t}
${n}`:e==="top"?(t,n)=>`${n}
${t}`:(t,n)=>`${t}
${n}`}function $4(e){return e==="time"?gd:e==="utc"?Fl:H4}function DT(e,t,n){let i=An(I1(t,(r,s)=>Math.abs(s-r)));if(i<1e3)return IT("millisecond","utc",n);for(let[r,s,o,a]of $4(e)){if(i>a||r==="hour"&&!i)break;if(t.every(c=>s.floor(c)>=c))return IT(r,o,n)}}function Fa(e,t,n){return(i,r,s)=>{let o=e(i,r),a=t(i,r),c=r-Yr(s);return r!==c&&s[c]!==void 0&&a===t(s[c],c)?o:n(o,a)}}var tx=Object.getPrototypeOf(Uint8Array),X4=Object.prototype.toString;function Ui(e){return e instanceof Array||e instanceof tx}function OT(e){return e instanceof tx&&!q4(e)}function BT(e){return e?.prototype instanceof tx&&!Y4(e)}function q4(e){return e instanceof BigInt64Array||e instanceof BigUint64Array}function Y4(e){return e===BigInt64Array||e===BigUint64Array}var ex=Symbol("reindex");function Se(e,t,n){let i=typeof t;return i==="string"?tA(e)?nx(e.getChild(t),n):FT(e,ix(t),n):i==="function"?FT(e,t,n):i==="number"||t instanceof Date||i==="boolean"?de(e,jn(t),n):typeof t?.transform=="function"?Qy(t.transform(e),n):Z4(Qy(t,n),e?.[ex])}function Z4(e,t){return e!=null&&t?vd(e,t):e}function FT(e,t,n){return de(e,BT(n)?(i,r)=>rx(t(i,r)):t,n)}function Qy(e,t){return t===void 0?pr(e):eA(e)?nx(e,t):e instanceof t?e:t.from(e,BT(t)&&!OT(e)?rx:void 0)}function nx(e,t){return e==null?e:(t===void 0||t===Array)&&Q4(e.type)?sx(UT(e)):Qy(UT(e),t)}function UT(e){return e.nullCount?e.toJSON():e.toArray()}var Ba=[null],ix=e=>t=>{let n=t[e];return n===void 0&&t.type==="Feature"?t.properties?.[e]:n},hr={transform:Pn},pe={transform:e=>e};var kT=()=>1,zT=()=>!0,De=e=>e==null?e:`${e}`,Fe=e=>e==null?e:+e;var xd=e=>e?e[0]:void 0,Ol=e=>e?e[1]:void 0;var jn=e=>()=>e;function GT(e){let t=+`${e}`.slice(1)/100;return(n,i)=>Ur(n,t,i)}function dr(e){return OT(e)?e:de(e,rx,Float64Array)}function rx(e){return e==null?NaN:Number(e)}function sx(e){return de(e,ox)}function ox(e){return e instanceof Date&&!isNaN(e)?e:typeof e=="string"?Dl(e):e==null||isNaN(e=Number(e))?void 0:new Date(e)}function Gn(e,t){return e===void 0&&(e=t),e===null?[void 0,"none"]:Wa(e)?[void 0,e]:[e,void 0]}function Pe(e,t){return e===void 0&&(e=t),e===null||typeof e=="number"?[void 0,e]:[e,void 0]}function ax(e,t,n){if(e!=null)return In(e,t,n)}function In(e,t,n){let i=`${e}`.toLowerCase();if(!n.includes(i))throw new Error(`invalid ${t}: ${e}`);return i}function Zr(e){return tA(e)?e:pr(e)}function pr(e){if(e==null||Ui(e))return e;if(eA(e))return nx(e);if(VT(e))switch(e.type){case"FeatureCollection":return e.features;case"GeometryCollection":return e.geometries;default:return[e]}return Array.from(e)}function VT(e){switch(e?.type){case"FeatureCollection":case"GeometryCollection":case"Feature":case"LineString":case"MultiLineString":case"MultiPoint":case"MultiPolygon":case"Point":case"Polygon":case"Sphere":return!0;default:return!1}}function de(e,t,n=Array){return e==null?e:e instanceof n?e.map(t):n.from(e,t)}function Rs(e,t=Array){return e instanceof t?e.slice():t.from(e)}function cx({x:e,x1:t,x2:n}){return e!==void 0||t!==void 0||n!==void 0}function lx({y:e,y1:t,y2:n}){return e!==void 0||t!==void 0||n!==void 0}function _d(e){return cx(e)||lx(e)||e.interval!==void 0}function Oi(e){return e?.toString===X4}function ka(e){return Oi(e)&&(e.type!==void 0||e.domain!==void 0)}function za(e){return Oi(e)&&typeof e.transform!="function"}function Is(e){return za(e)&&e.value===void 0&&e.channel===void 0}function ux(e,t,n,i=pe){return t===void 0&&n===void 0?(t=0,n=e===void 0?i:e):t===void 0?t=e===void 0?0:e:n===void 0&&(n=e===void 0?0:e),[t,n]}function Bi(e,t){return e===void 0&&t===void 0?[xd,Ol]:[e,t]}function Ga({z:e,fill:t,stroke:n}={}){return e===void 0&&([e]=Gn(t)),e===void 0&&([e]=Gn(n)),e}function Ps(e){return Ui(e)?e.length:e?.numRows}function Pn(e){let t=Ps(e),n=new Uint32Array(t);for(let i=0;i<t;++i)n[i]=i;return n}function vd(e,t){return Ui(e)?de(t,n=>e[n],e.constructor):de(t,n=>e.at(n))}function HT(e,t,n){return e.subarray?e.subarray(t,n):e.slice(t,n)}function _i(e){return e!==null&&typeof e=="object"?e.valueOf():e}function WT(e,t){if(t[e]!==void 0)return t[e];switch(e){case"x1":case"x2":e="x";break;case"y1":case"y2":e="y";break}return t[e]}function Va(e){let t;return[{transform:()=>t,label:ki(e)},n=>t=n]}function vi(e){return e==null?[e]:Va(e)}function ki(e,t){return typeof e=="string"?e:e&&e.label!==void 0?e.label:t}function Ha(e,t){return{transform(n){let i=e.transform(n),r=t.transform(n);return Ne(i)||Ne(r)?de(i,(s,o)=>new Date((+i[o]+ +r[o])/2)):de(i,(s,o)=>(+i[o]+ +r[o])/2,Float64Array)},label:e.label}}function Bl(e,t){let n=fx(t?.interval,t?.type);return n?de(e,n):e}function fx(e,t){let n=bd(e,t);return n&&(i=>xi(i)?n.floor(i):i)}function bd(e,t){if(e!=null){if(typeof e=="number")return J4(e);if(typeof e=="string")return(t==="time"?Ky:Ul)(e);if(typeof e.floor!="function")throw new Error("invalid interval; missing floor method");if(typeof e.offset!="function")throw new Error("invalid interval; missing offset method");return e}}function J4(e){e=+e,0<e&&e<1&&Number.isInteger(1/e)&&(e=-1/e);let t=Math.abs(e);return e<0?{floor:n=>Math.floor(n*t)/t,offset:(n,i=1)=>(n*t+Math.floor(i))/t,range:(n,i)=>ga(Math.ceil(n*t),i*t).map(r=>r/t)}:{floor:n=>Math.floor(n/t)*t,offset:(n,i=1)=>n+t*Math.floor(i),range:(n,i)=>ga(Math.ceil(n/t),i/t).map(r=>r*t)}}function mr(e,t){if(e=bd(e,t),e&&typeof e.range!="function")throw new Error("invalid interval: missing range method");return e}function $T(e,t){if(e=mr(e,t),e&&typeof e.ceil!="function")throw new Error("invalid interval: missing ceil method");return e}function XT(e){return Ls(e)&&typeof e?.floor=="function"&&e.floor()instanceof Date}function Ls(e){return typeof e?.range=="function"}function gr(e){return e===void 0||za(e)?e:{value:e}}function qT(e){return e==null?null:{transform:t=>Se(t,e,Float64Array),label:ki(e)}}function Vn(e){return e&&typeof e[Symbol.iterator]=="function"}function Md(e){for(let t of e)if(t!=null)return typeof t!="object"||t instanceof Date}function hx(e){for(let t of e){if(t==null)continue;let n=typeof t;return n==="string"||n==="boolean"}}function Ne(e){for(let t of e)if(t!=null)return t instanceof Date}function YT(e){for(let t of e)if(t!=null)return typeof t=="string"&&isNaN(t)&&Dl(t)}function ZT(e){for(let t of e)if(t!=null){if(typeof t!="string")return!1;if(t.trim())return!isNaN(t)}}function JT(e){for(let t of e)if(t!=null)return typeof t=="number"}function Sd(e,t){let n;for(let i of e)if(i!=null){if(!t(i))return!1;n=!0}return n}var K4=new Set("none,currentcolor,transparent,aliceblue,antiquewhite,aqua,aquamarine,azure,beige,bisque,black,blanchedalmond,blue,blueviolet,brown,burlywood,cadetblue,chartreuse,chocolate,coral,cornflowerblue,cornsilk,crimson,cyan,darkblue,darkcyan,darkgoldenrod,darkgray,darkgreen,darkgrey,darkkhaki,darkmagenta,darkolivegreen,darkorange,darkorchid,darkred,darksalmon,darkseagreen,darkslateblue,darkslategray,darkslategrey,darkturquoise,darkviolet,deeppink,deepskyblue,dimgray,dimgrey,dodgerblue,firebrick,floralwhite,forestgreen,fuchsia,gainsboro,ghostwhite,gold,goldenrod,gray,green,greenyellow,grey,honeydew,hotpink,indianred,indigo,ivory,khaki,lavender,lavenderblush,lawngreen,lemonchiffon,lightblue,lightcoral,lightcyan,lightgoldenrodyellow,lightgray,lightgreen,lightgrey,lightpink,lightsalmon,lightseagreen,lightskyblue,lightslategray,lightslategrey,lightsteelblue,lightyellow,lime,limegreen,linen,magenta,maroon,mediumaquamarine,mediumblue,mediumorchid,mediumpurple,mediumseagreen,mediumslateblue,mediumspringgreen,mediumturquoise,mediumvioletred,midnightblue,mintcream,mistyrose,moccasin,navajowhite,navy,oldlace,olive,olivedrab,orange,orangered,orchid,palegoldenrod,palegreen,paleturquoise,palevioletred,papayawhip,peachpuff,peru,pink,plum,powderblue,purple,rebeccapurple,red,rosybrown,royalblue,saddlebrown,salmon,sandybrown,seagreen,seashell,sienna,silver,skyblue,slateblue,slategray,slategrey,snow,springgreen,steelblue,tan,teal,thistle,tomato,turquoise,violet,wheat,white,whitesmoke,yellow".split(","));function Wa(e){return typeof e!="string"?!1:(e=e.toLowerCase().trim(),/^#[0-9a-f]{3,8}$/.test(e)||/^(?:url|var|rgb|rgba|hsl|hsla|hwb|lab|lch|oklab|oklch|color|color-mix)\(.*\)$/.test(e)||K4.has(e))}function KT(e){return typeof e=="number"&&(0<=e&&e<=1||isNaN(e))}function rn(e){return e==null||To(e)}function To(e){return/^\s*none\s*$/i.test(e)}function jT(e){return/^\s*round\s*$/i.test(e)}function wd(e,t){return ax(e,t,["middle","top-left","top","top-right","right","bottom-right","bottom","bottom-left","left"])}function Ns(e="middle"){return wd(e,"frameAnchor")}function QT(e={},...t){let n=e;for(let i of t)for(let r in i)if(n[r]===void 0){let s=i[r];n===e?n={...n,[r]:s}:n[r]=s}return n}function j4(e){console.warn("named iterables are deprecated; please use an object instead");let t=new Set;return Object.fromEntries(Array.from(e,n=>{let{name:i}=n;if(i==null)throw new Error("missing name");let r=`${i}`;if(r==="__proto__")throw new Error(`illegal name: ${r}`);if(t.has(r))throw new Error(`duplicate name: ${r}`);return t.add(r),[i,n]}))}function dx(e){return Vn(e)?j4(e):e}function Td(e){return e===!0?e="frame":e===!1?e=null:!VT(e)&&e!=null&&(e=In(e,"clip",["frame","sphere"]),e==="sphere"&&(e={type:"Sphere"})),e}function tA(e){return e&&typeof e.getChild=="function"&&typeof e.toArray=="function"&&e.schema&&Array.isArray(e.schema.fields)}function eA(e){return e&&typeof e.toArray=="function"&&e.type}function Q4(e){return e&&(e.typeId===8||e.typeId===10)&&e.unit===1}var bi=Symbol("position"),Qn=Symbol("color"),Ao=Symbol("radius"),Eo=Symbol("length"),Co=Symbol("opacity"),$a=Symbol("symbol"),nA=Symbol("projection"),me=new Map([["x",bi],["y",bi],["fx",bi],["fy",bi],["r",Ao],["color",Qn],["opacity",Co],["symbol",$a],["length",Eo],["projection",nA]]);function iA(e){return e===bi||e===nA}function rA(e){return e===bi||e===Ao||e===Eo||e===Co}var t5=Math.sqrt(3),e5=2/t5,n5={draw(e,t){let n=Math.sqrt(t/Math.PI),i=n*e5,r=i/2;e.moveTo(0,i),e.lineTo(n,r),e.lineTo(n,-r),e.lineTo(0,-i),e.lineTo(-n,-r),e.lineTo(-n,r),e.closePath()}},px=new Map([["asterisk",Py],["circle",bo],["cross",Ly],["diamond",Ny],["diamond2",Dy],["hexagon",n5],["plus",Fy],["square",Uy],["square2",Oy],["star",By],["times",Vy],["triangle",ky],["triangle2",zy],["wye",Gy]]);function mx(e){return e&&typeof e.draw=="function"}function sA(e){return mx(e)?!0:typeof e!="string"?!1:px.has(e.toLowerCase())}function Xa(e){if(e==null||mx(e))return e;let t=px.get(`${e}`.toLowerCase());if(t)return t;throw new Error(`invalid symbol: ${e}`)}function oA(e){if(e==null||mx(e))return[void 0,e];if(typeof e=="string"){let t=px.get(`${e}`.toLowerCase());if(t)return[void 0,t]}return[e,void 0]}function Ro({filter:e,sort:t,reverse:n,transform:i,initializer:r,...s}={},o){if(i===void 0&&(e!=null&&(i=aA(e)),t!=null&&!Is(t)&&(i=gx(i,xx(t))),n&&(i=gx(i,cA))),o!=null&&r!=null)throw new Error("transforms cannot be applied after initializers");return{...s,...(t===null||Is(t))&&{sort:t},transform:gx(i,o)}}function Jr({filter:e,sort:t,reverse:n,initializer:i,...r}={},s){return i===void 0&&(e!=null&&(i=aA(e)),t!=null&&!Is(t)&&(i=yx(i,xx(t))),n&&(i=yx(i,cA))),{...r,...(t===null||Is(t))&&{sort:t},initializer:yx(i,s)}}function gx(e,t){return e==null?t===null?void 0:t:t==null?e===null?void 0:e:function(n,i,r){return{data:n,facets:i}=e.call(this,n,i,r),t.call(this,Zr(n),i,r)}}function yx(e,t){return e==null?t===null?void 0:t:t==null?e===null?void 0:e:function(n,i,r,...s){let o,a,c,l,u,h;return{data:a=n,facets:c=i,channels:o}=e.call(this,n,i,r,...s),{data:u=a,facets:h=c,channels:l}=t.call(this,a,c,{...r,...o},...s),{data:u,facets:h,channels:{...o,...l}}}}function i5(e,t){return(e.initializer!=null?Jr:Ro)(e,t)}function aA(e){return(t,n)=>{let i=Se(t,e);return{data:t,facets:n.map(r=>r.filter(s=>i[s]))}}}function cA(e,t){return{data:e,facets:t.map(n=>n.slice().reverse())}}function lA(e,{sort:t,...n}={}){return{...(za(e)&&e.channel!==void 0?Jr:i5)(n,xx(e)),sort:Is(t)?t:null}}function xx(e){return(typeof e=="function"&&e.length!==1?r5:s5)(e)}function r5(e){return(t,n)=>{let i=Ui(t)?(r,s)=>e(t[r],t[s]):(r,s)=>e(t.get(r),t.get(s));return{data:t,facets:n.map(r=>r.slice().sort(i))}}}function s5(e){let t,n;({channel:t,value:e,order:n}={...gr(e)});let i=t?.startsWith("-");if(i&&(t=t.slice(1)),n===void 0&&(n=i?Mo:yn),typeof n!="function")switch(`${n}`.toLowerCase()){case"ascending":n=yn;break;case"descending":n=Mo;break;default:throw new Error(`invalid order: ${n}`)}return(r,s,o)=>{let a;if(t===void 0)a=Se(r,e);else{if(o===void 0)throw new Error("channel sort requires an initializer");if(a=o[t],!a)return{};a=a.value}let c=(l,u)=>n(a[l],a[u]);return{data:r,facets:s.map(l=>l.slice().sort(c))}}}function zl(e,...t){for(let{name:n}of e)if(t.includes(n))return!0;return!1}function hA(e,t,n=_x){let i=Object.entries(e);return t.title!=null&&e.title===void 0&&i.push(["title",u5]),t.href!=null&&e.href===void 0&&i.push(["href",Ad]),i.filter(([,r])=>r!==void 0).map(([r,s])=>s===null?o5(r):n(r,s,t))}function _x(e,t,n,i=vx){let r;Oi(t)&&"reduce"in t&&(r=t.scale,t=t.reduce);let s=i(e,t,n),[o,a]=Va(s.label),c;return{name:e,output:r===void 0?o:{value:o,scale:r},initialize(l){s.initialize(l),c=a([])},scope(l,u){s.scope(l,u)},reduce(l,u){c.push(s.reduce(l,u))}}}function o5(e){return{name:e,initialize(){},scope(){},reduce(){}}}function vx(e,t,n,i=Gl){let r=WT(e,n),s=i(t,r),o,a;return{label:ki(s===kl?null:r,s.label),initialize(c){o=r===void 0?c:Se(c,r),s.scope==="data"&&(a=s.reduceIndex(Pn(c),o))},scope(c,l){s.scope===c&&(a=s.reduceIndex(l,o))},reduce(c,l){return s.scope==null?s.reduceIndex(c,o,l):s.reduceIndex(c,o,a,l)}}}function bx(e,t){return t?to(e,n=>t[n]):[[,e]]}function Gl(e,t,n=a5){if(e==null)return n(e);if(typeof e.reduceIndex=="function")return e;if(typeof e.reduce=="function"&&Oi(e))return c5(e);if(typeof e=="function")return l5(e);if(/^p\d{2}$/i.test(e))return Kr(GT(e));switch(`${e}`.toLowerCase()){case"first":return Ad;case"last":return f5;case"identity":return Mx;case"count":return kl;case"distinct":return h5;case"sum":return t==null?kl:d5;case"proportion":return fA(t,"data");case"proportion-facet":return fA(t,"facet");case"deviation":return Kr(Ym);case"min":return Kr(ci);case"min-index":return Kr(w1);case"max":return Kr(An);case"max-index":return Kr(S1);case"mean":return uA(C1);case"median":return uA(el);case"variance":return Kr(qm);case"mode":return Kr(R1)}return n(e)}function a5(e){throw new Error(`invalid reduce: ${e}`)}function dA(e,t){for(let n in t){let i=t[n];if(i!==void 0&&!e.some(r=>r.name===n))return i}}function pA(e,t,n){if(t){let i=t.output.transform(),r=(s,o)=>yn(i[s],i[o]);e.forEach(s=>s.sort(r))}n&&e.forEach(i=>i.reverse())}function c5(e){return console.warn("deprecated reduce interface; implement reduceIndex instead."),{...e,reduceIndex:e.reduce.bind(e)}}function l5(e){return{reduceIndex(t,n,i){return e(vd(n,t),i)}}}function Kr(e){return{reduceIndex(t,n){return e(t,i=>n[i])}}}function uA(e){return{reduceIndex(t,n){let i=e(t,r=>n[r]);return Ne(n)?new Date(i):i}}}var Mx={reduceIndex(e,t){return vd(t,e)}},Ad={reduceIndex(e,t){return t[e[0]]}},u5={reduceIndex(e,t){let i=ha(Br(e,s=>s.length,s=>t[s]),Ol),r=i.slice(-5).reverse();if(r.length<i.length){let s=i.slice(0,-4);r[4]=[`… ${s.length.toLocaleString("en-US")} more`,Li(s,Ol)]}return r.map(([s,o])=>`${s} (${o.toLocaleString("en-US")})`).join(`
`)}},f5={reduceIndex(e,t){return t[e[e.length-1]]}},kl={label:"Frequency",reduceIndex(e){return e.length}},h5={label:"Distinct",reduceIndex(e,t){let n=new ji;for(let i of e)n.add(t[i]);return n.size}},d5=Kr(Li);function fA(e,t){return e==null?{scope:t,label:"Frequency",reduceIndex:(n,i,r=1)=>n.length/r}:{scope:t,reduceIndex:(n,i,r=1)=>Li(n,s=>i[s])/r}}var mA={reduceIndex(e,t,{z:n}){return n}};function qa(e,{scale:t,type:n,value:i,filter:r,hint:s,label:o=ki(i)},a){return s===void 0&&typeof i?.transform=="function"&&(s=i.hint),wx(a,{scale:t,type:n,value:Se(e,i),label:o,filter:r,hint:s})}function yA(e,t){return Object.fromEntries(Object.entries(e).map(([n,i])=>[n,qa(t,i,n)]))}function xA(e,t){let n=Object.fromEntries(Object.entries(e).map(([i,{scale:r,value:s}])=>{let o=r==null?null:t[r];return[i,o==null?s:de(s,o)]}));return n.channels=e,n}function wx(e,t){let{scale:n,value:i}=t;if(n===!0||n==="auto")switch(e){case"fill":case"stroke":case"color":t.scale=n!==!0&&Sd(i,Wa)?null:"color",t.defaultScale="color";break;case"fillOpacity":case"strokeOpacity":case"opacity":t.scale=n!==!0&&Sd(i,KT)?null:"opacity",t.defaultScale="opacity";break;case"symbol":n!==!0&&Sd(i,sA)?(t.scale=null,t.value=de(i,Xa)):t.scale="symbol",t.defaultScale="symbol";break;default:t.scale=me.has(e)?e:null;break}else if(n===!1)t.scale=null;else if(n!=null&&!me.has(n))throw new Error(`unknown scale: ${n}`);return t}function _A(e,t,n,i,r){let{order:s,reverse:o,reduce:a=!0,limit:c}=r;for(let l in r){if(!me.has(l))continue;let{value:u,order:h=s,reverse:f=o,reduce:d=a,limit:p=c}=gr(r[l]),y=u?.startsWith("-");if(y&&(u=u.slice(1)),h=h===void 0?y!==(u==="width"||u==="height")?bA:vA:g5(h),d==null||d===!1)continue;let m=l==="fx"||l==="fy"?m5(t,i[l]):p5(n,l);if(!m)throw new Error(`missing channel for scale: ${l}`);let g=m.value,[v=0,S=1/0]=Vn(p)?p:p<0?[p]:[0,p];if(u==null)m.domain=()=>{let _=Array.from(new ji(g));return f&&(_=_.reverse()),(v!==0||S!==1/0)&&(_=_.slice(v,S)),_};else{let _=u==="data"?e:u==="height"?gA(n,"y1","y2"):u==="width"?gA(n,"x1","x2"):Sx(n,u,u==="y"?"y2":u==="x"?"x2":void 0),w=Gl(d===!0?"max":d,_);m.domain=()=>{let b=v1(Pn(g),x=>w.reduceIndex(x,_),x=>g[x]);return h&&b.sort(h),f&&b.reverse(),(v!==0||S!==1/0)&&(b=b.slice(v,S)),b.map(xd)}}}}function p5(e,t){for(let n in e){let i=e[n];if(i.scale===t)return i}}function m5(e,t){let n=e.original;if(n===e)return t;let i=t.value,r=t.value=[];for(let s=0;s<n.length;++s){let o=i[n[s][0]];for(let a of e[s])r[a]=o}return t}function gA(e,t,n){let i=Sx(e,t),r=Sx(e,n);return de(r,(s,o)=>Math.abs(s-i[o]),Float64Array)}function Sx(e,t,n){let i=e[t];if(!i&&n!==void 0&&(i=e[n]),i)return i.value;throw new Error(`missing channel: ${t}`)}function g5(e){if(e==null||typeof e=="function")return e;switch(`${e}`.toLowerCase()){case"ascending":return vA;case"descending":return bA}throw new Error(`invalid order: ${e}`)}function vA([e,t],[n,i]){return yn(t,i)||yn(e,n)}function bA([e,t],[n,i]){return Mo(t,i)||yn(e,n)}function Tx(e,t){let n=e[t];if(n){for(;n.source;)n=n.source;return n.source===null?null:n}}var AA=new Map([["accent",Cw],["category10",Ew],["dark2",Rw],["observable10",Iw],["paired",Pw],["pastel1",Lw],["pastel2",Nw],["set1",Dw],["set2",Fw],["set3",Uw],["tableau10",Ow]]);function EA(e){return e!=null&&AA.has(`${e}`.toLowerCase())}var MA=new Map([...AA,["brbg",jr(_0,v0)],["prgn",jr(b0,M0)],["piyg",jr(S0,w0)],["puor",jr(T0,A0)],["rdbu",jr(rd,Il)],["rdgy",jr(E0,C0)],["rdylbu",jr(sd,Pl)],["rdylgn",jr(R0,I0)],["spectral",jr(P0,L0)],["burd",SA(rd,Il)],["buylrd",SA(sd,Pl)],["blues",sn(iy,ry)],["greens",sn(sy,oy)],["greys",sn(ay,cy)],["oranges",sn(dy,py)],["purples",sn(ly,uy)],["reds",sn(fy,hy)],["turbo",Qr(by)],["viridis",Qr(My)],["magma",Qr(Sy)],["inferno",Qr(wy)],["plasma",Qr(Ty)],["cividis",Qr(my)],["cubehelix",Qr(gy)],["warm",Qr(yy)],["cool",Qr(xy)],["bugn",sn(N0,D0)],["bupu",sn(F0,U0)],["gnbu",sn(O0,B0)],["orrd",sn(k0,z0)],["pubu",sn(H0,W0)],["pubugn",sn(G0,V0)],["purd",sn($0,X0)],["rdpu",sn(q0,Y0)],["ylgn",sn(K0,j0)],["ylgnbu",sn(Z0,J0)],["ylorbr",sn(Q0,ty)],["ylorrd",sn(ey,ny)],["rainbow",wA(_y)],["sinebow",wA(vy)]]);function sn(e,t){return({length:n})=>n===1?[e[3][1]]:n===2?[e[3][1],e[3][2]]:(n=Math.max(3,Math.floor(n)),n>9?En(t,n):e[n])}function jr(e,t){return({length:n})=>n===2?[e[3][0],e[3][2]]:(n=Math.max(3,Math.floor(n)),n>11?En(t,n):e[n])}function SA(e,t){return({length:n})=>n===2?[e[3][2],e[3][0]]:(n=Math.max(3,Math.floor(n)),n>11?En(i=>t(1-i),n):e[n].slice().reverse())}function Qr(e){return({length:t})=>En(e,Math.max(2,Math.floor(t)))}function wA(e){return({length:t})=>En(e,Math.floor(t)+1).slice(0,-1)}function Ax(e){let t=`${e}`.toLowerCase();if(!MA.has(t))throw new Error(`unknown ordinal scheme: ${t}`);return MA.get(t)}function Vl(e,t){let n=Ax(e),i=typeof n=="function"?n({length:t}):n;return i.length!==t?i.slice(0,t):i}function CA(e,t="greys"){let n=new Set,[i,r]=Vl(t,2);for(let s of e)if(s!=null)if(s===!0)n.add(r);else if(s===!1)n.add(i);else return;return[...n]}var TA=new Map([["brbg",v0],["prgn",M0],["piyg",w0],["puor",A0],["rdbu",Il],["rdgy",C0],["rdylbu",Pl],["rdylgn",I0],["spectral",L0],["burd",e=>Il(1-e)],["buylrd",e=>Pl(1-e)],["blues",ry],["greens",oy],["greys",cy],["purples",uy],["reds",hy],["oranges",py],["turbo",by],["viridis",My],["magma",Sy],["inferno",wy],["plasma",Ty],["cividis",my],["cubehelix",gy],["warm",yy],["cool",xy],["bugn",D0],["bupu",U0],["gnbu",B0],["orrd",z0],["pubugn",V0],["pubu",W0],["purd",X0],["rdpu",Y0],["ylgnbu",J0],["ylgn",j0],["ylorbr",ty],["ylorrd",ny],["rainbow",_y],["sinebow",vy]]);function Ya(e){let t=`${e}`.toLowerCase();if(!TA.has(t))throw new Error(`unknown quantitative scheme: ${t}`);return TA.get(t)}var y5=new Set(["brbg","prgn","piyg","puor","rdbu","rdgy","rdylbu","rdylgn","spectral","burd","buylrd"]);function RA(e){return e!=null&&y5.has(`${e}`.toLowerCase())}var Cx=e=>t=>e(1-t),Ex=[0,1],IA=new Map([["number",He],["rgb",so],["hsl",MM],["hcl",TM],["lab",SM]]);function Rx(e){let t=`${e}`.toLowerCase();if(!IA.has(t))throw new Error(`unknown interpolator: ${t}`);return IA.get(t)}function Ja(e,t,n,{type:i,nice:r,clamp:s,zero:o,domain:a=kA(e,n),unknown:c,round:l,scheme:u,interval:h,range:f=me.get(e)===Ao?b5(n,a):me.get(e)===Eo?M5(n,a):me.get(e)===Co?Ex:void 0,interpolate:d=me.get(e)===Qn?u==null&&f!==void 0?so:Ya(u!==void 0?u:i==="cyclical"?"rainbow":"turbo"):l?sl:He,reverse:p}){if(a=PA(a),h=mr(h,i),(i==="cyclical"||i==="sequential")&&(i="linear"),typeof d!="function"&&(d=Rx(d)),p=!!p,f!==void 0){let y=a.length,m=(f=PA(f)).length;if(y!==m){if(d.length===1)throw new Error("invalid piecewise interpolator");d=Ms(d,f),f=void 0}}if(d.length===1?(p&&(d=Cx(d),p=!1),f===void 0&&(f=Float64Array.from(a,(y,m)=>m/(a.length-1)),f.length===2&&(f=Ex)),t.interpolate((f===Ex?jn:Hl)(d))):t.interpolate(d),o){let[y,m]=cn(a);(y>0||m<0)&&(a=Rs(a),(Yr(a)||1)===Math.sign(y)?a[0]=0:a[a.length-1]=0)}return p&&(a=ya(a)),t.domain(a).unknown(c),r&&(t.nice(x5(r,i)),a=t.domain()),f!==void 0&&t.range(f),s&&t.clamp(s),{type:i,domain:a,range:f,scale:t,interpolate:d,interval:h}}function PA(e){return e=pr(e),e.length>=2?e:[e[0],e[0]]}function x5(e,t){return e===!0?void 0:typeof e=="number"?e:$T(e,t)}function LA(e,t,n){return Ja(e,Rl(),t,n)}function NA(e,t,n){return Ix(e,t,{...n,exponent:.5})}function Ix(e,t,{exponent:n=1,...i}){return Ja(e,f0().exponent(n),t,{...i,type:"pow"})}function DA(e,t,{base:n=10,domain:i=S5(t),...r}){return Ja(e,l0().base(n),t,{...r,domain:i})}function FA(e,t,{constant:n=1,...i}){return Ja(e,u0().constant(n),t,i)}function UA(e,t,{range:n,quantiles:i=n===void 0?5:(n=[...n]).length,n:r=i,scheme:s="rdylbu",domain:o=w5(t),unknown:a,interpolate:c,reverse:l}){return n===void 0&&(n=c!==void 0?En(c,r):me.get(e)===Qn?Vl(s,r):void 0),o.length>0&&(o=h0(o,n===void 0?{length:r}:n).quantiles()),Ed(e,t,{domain:o,range:n,reverse:l,unknown:a})}function OA(e,t,{range:n,n:i=n===void 0?5:(n=[...n]).length,scheme:r="rdylbu",domain:s=kA(e,t),unknown:o,interpolate:a,reverse:c}){let[l,u]=cn(s),h;return n===void 0?(h=_s(l,u,i),h[0]<=l&&h.splice(0,1),h[h.length-1]>=u&&h.pop(),i=h.length+1,n=a!==void 0?En(a,i):me.get(e)===Qn?Vl(r,i):void 0):(h=En(He(l,u),i+1).slice(1,-1),l instanceof Date&&(h=h.map(f=>new Date(f)))),Yr(pr(s))<0&&h.reverse(),Ed(e,t,{domain:h,range:n,reverse:c,unknown:o})}function Ed(e,t,{domain:n=[0],unknown:i,scheme:r="rdylbu",interpolate:s,range:o=s!==void 0?En(s,n.length+1):me.get(e)===Qn?Vl(r,n.length+1):void 0,reverse:a}){n=pr(n);let c=Yr(n);if(!isNaN(c)&&!_5(n,c))throw new Error(`the ${e} scale has a non-monotonic domain`);return a&&(o=ya(o)),{type:"threshold",scale:d0(c<0?ya(n):n,o===void 0?[]:o).unknown(i),domain:n,range:o}}function _5(e,t){for(let n=1,i=e.length,r=e[0];n<i;++n){let s=Or(r,r=e[n]);if(s!==0&&s!==t)return!1}return!0}function BA(e){return{type:"identity",scale:rA(me.get(e))?c0():t=>t}}function Za(e,t=qy){return e.length?[ci(e,({value:n})=>n===void 0?n:ci(n,t)),An(e,({value:n})=>n===void 0?n:An(n,t))]:[0,1]}function kA(e,t){let n=me.get(e);return(n===Ao||n===Co||n===Eo?v5:Za)(t)}function v5(e){return[0,e.length?An(e,({value:t})=>t===void 0?t:An(t,qy)):1]}function b5(e,t){let n=e.find(({radius:o})=>o!==void 0);if(n!==void 0)return[0,n.radius];let i=Ur(e,.5,({value:o})=>o===void 0?NaN:Ur(o,.25,So)),r=t.map(o=>3*Math.sqrt(o/i)),s=30/An(r);return s<1?r.map(o=>o*s):r}function M5(e,t){let n=el(e,({value:s})=>s===void 0?NaN:el(s,Math.abs)),i=t.map(s=>12*s/n),r=60/An(i);return r<1?i.map(s=>s*r):i}function S5(e){for(let{value:t}of e)if(t!==void 0)for(let n of t){if(n>0)return Za(e,So);if(n<0)return Za(e,Da)}return[1,10]}function w5(e){let t=[];for(let{value:n}of e)if(n!==void 0)for(let i of n)t.push(i);return t}function Hl(e){return(t,n)=>i=>e(t+i*(n-t))}var Px=0,Lx;function zA(){let e=Px;return Px=0,Lx=void 0,e}function Hn(e){e!==Lx&&(Lx=e,console.warn(e),++Px)}function Cd(e,t,n,i,{type:r,nice:s,clamp:o,domain:a=Za(i),unknown:c,pivot:l=0,scheme:u,range:h,symmetric:f=!0,interpolate:d=me.get(e)===Qn?u==null&&h!==void 0?so:Ya(u!==void 0?u:"rdbu"):He,reverse:p}){l=+l,a=pr(a);let[y,m]=a;if(a.length>2&&Hn(`Warning: the diverging ${e} scale domain contains extra elements.`),Or(y,m)<0&&([y,m]=[m,y],p=!p),y=Math.min(y,l),m=Math.max(m,l),typeof d!="function"&&(d=Rx(d)),h!==void 0&&(d=d.length===1?Hl(d)(...h):Ms(d,h)),p&&(d=Cx(d)),f){let g=n.apply(l),v=g-n.apply(y),S=n.apply(m)-g;v<S?y=n.invert(g-S):v>S&&(m=n.invert(g+v))}return t.domain([y,l,m]).unknown(c).interpolator(d),o&&t.clamp(o),s&&t.nice(s),{type:r,domain:[y,m],pivot:l,interpolate:d,scale:t}}function GA(e,t,n){return Cd(e,m0(),T5,t,n)}function VA(e,t,n){return Nx(e,t,{...n,exponent:.5})}function Nx(e,t,{exponent:n=1,...i}){return Cd(e,x0().exponent(n=+n),C5(n),t,{...i,type:"diverging-pow"})}function HA(e,t,{base:n=10,pivot:i=1,domain:r=Za(t,i<0?Da:So),...s}){return Cd(e,g0().base(n=+n),A5,t,{domain:r,pivot:i,...s})}function WA(e,t,{constant:n=1,...i}){return Cd(e,y0().constant(n=+n),R5(n),t,i)}var T5={apply(e){return e},invert(e){return e}},A5={apply:Math.log,invert:Math.exp},E5={apply(e){return Math.sign(e)*Math.sqrt(Math.abs(e))},invert(e){return Math.sign(e)*(e*e)}};function C5(e){return e===.5?E5:{apply(t){return Math.sign(t)*Math.pow(Math.abs(t),e)},invert(t){return Math.sign(t)*Math.pow(Math.abs(t),1/e)}}}function R5(e){return{apply(t){return Math.sign(t)*Math.log1p(Math.abs(t/e))},invert(t){return Math.sign(t)*Math.expm1(Math.abs(t))*e}}}function $A(e,t,n,i){return Ja(e,t,n,i)}function XA(e,t,n){return $A(e,Tw(),t,n)}function qA(e,t,n){return $A(e,Aw(),t,n)}var Ka=Symbol("ordinal");function ZA(e,t,n,{type:i,interval:r,domain:s,range:o,reverse:a,hint:c}){return r=mr(r,i),s===void 0&&(s=tE(n,r,e)),(i==="categorical"||i===Ka)&&(i="ordinal"),a&&(s=ya(s)),s=t.domain(s).domain(),o!==void 0&&(typeof o=="function"&&(o=o(s)),t.range(o)),{type:i,domain:s,range:o,scale:t,hint:c,interval:r}}function JA(e,t,{type:n,interval:i,domain:r,range:s,scheme:o,unknown:a,...c}){i=mr(i,n),r===void 0&&(r=tE(t,i,e));let l;if(me.get(e)===$a)l=I5(t),s=s===void 0?P5(l):de(s,Xa);else if(me.get(e)===Qn&&(s===void 0&&(n==="ordinal"||n===Ka)&&(s=CA(r,o),s!==void 0&&(o=void 0)),o===void 0&&s===void 0&&(o=n==="ordinal"?"turbo":"observable10"),o!==void 0))if(s!==void 0){let u=Ya(o),h=s[0],f=s[1]-s[0];s=({length:d})=>En(p=>u(h+f*p),d)}else s=Ax(o);if(a===Jh)throw new Error(`implicit unknown on ${e} scale is not supported`);return ZA(e,jh().unknown(a),t,{...c,type:n,domain:r,range:s,hint:l})}function KA(e,t,{align:n=.5,padding:i=.5,...r}){return QA(_w().align(n).padding(i),t,r,e)}function jA(e,t,{align:n=.5,padding:i=.1,paddingInner:r=i,paddingOuter:s=e==="fx"||e==="fy"?0:i,...o}){return QA(Na().align(n).paddingInner(r).paddingOuter(s),t,o,e)}function QA(e,t,n,i){let{round:r}=n;return r!==void 0&&e.round(r=!!r),e=ZA(i,e,t,n),e.round=r,e}function tE(e,t,n){let i=new ji;for(let{value:r,domain:s}of e){if(s!==void 0)return s();if(r!==void 0)for(let o of r)i.add(o)}if(t!==void 0){let[r,s]=cn(i).map(t.floor,t);return t.range(r,t.offset(s))}if(i.size>1e4&&me.get(n)===bi)throw new Error(`implicit ordinal domain of ${n} scale has more than 10,000 values`);return ha(i,yn)}function YA(e,t){let n;for(let{hint:i}of e){let r=i?.[t];if(r!==void 0){if(n===void 0)n=r;else if(n!==r)return}}return n}function I5(e){return{fill:YA(e,"fill"),stroke:YA(e,"stroke")}}function P5(e){return rn(e.fill)?nT:eT}function Wl(e,{label:t,inset:n=0,insetTop:i=n,insetRight:r=n,insetBottom:s=n,insetLeft:o=n,round:a,nice:c,clamp:l,zero:u,align:h,padding:f,projection:d,facet:{label:p=t}={},...y}={}){let m={};for(let[g,v]of e){let S=y[g],_=D5(g,v,{round:me.get(g)===bi?a:void 0,nice:c,clamp:l,zero:u,align:h,padding:f,projection:d,...S});if(_){let{label:w=g==="fx"||g==="fy"?p:t,percent:b,transform:x,inset:M,insetTop:R=M!==void 0?M:g==="y"?i:0,insetRight:E=M!==void 0?M:g==="x"?r:0,insetBottom:C=M!==void 0?M:g==="y"?s:0,insetLeft:N=M!==void 0?M:g==="x"?o:0}=S||{};if(x==null)x=void 0;else if(typeof x!="function")throw new Error("invalid scale transform; not a function");_.percent=!!b,_.label=w===void 0?L5(v,_):w,_.transform=x,g==="x"||g==="fx"?(_.insetLeft=+N,_.insetRight=+E):(g==="y"||g==="fy")&&(_.insetTop=+R,_.insetBottom=+C),m[g]=_}}return m}function Fx(e){let t={},n={scales:t};for(let[i,r]of Object.entries(e)){let{scale:s,type:o,interval:a,label:c}=r;t[i]=B5(r),n[i]=s,s.type=o,a!=null&&(s.interval=a),c!=null&&(s.label=c)}return n}function sE(e,t){let{x:n,y:i,fx:r,fy:s}=e,o=r||s?Id(t):t;r&&eE(r,o),s&&nE(s,o);let a=r||s?Ux(e,t):t;n&&eE(n,a),i&&nE(i,a)}function L5(e=[],t){let n;for(let{label:i}of e)if(i!==void 0){if(n===void 0)n=i;else if(n!==i)return}if(n!==void 0)return!yr(t)&&t.percent&&(n=`${n} (%)`),{inferred:!0,toString:()=>n}}function oE(e){return Math.sign(Yr(e.domain()))*Math.sign(Yr(e.range()))}function Id(e){let{marginTop:t,marginRight:n,marginBottom:i,marginLeft:r,width:s,height:o,facet:{marginTop:a,marginRight:c,marginBottom:l,marginLeft:u}}=e;return{marginTop:Math.max(t,a),marginRight:Math.max(n,c),marginBottom:Math.max(i,l),marginLeft:Math.max(r,u),width:s,height:o}}function Ux({fx:e,fy:t},n){let{marginTop:i,marginRight:r,marginBottom:s,marginLeft:o,width:a,height:c}=Id(n);return{marginTop:i,marginRight:r,marginBottom:s,marginLeft:o,width:e?e.scale.bandwidth()+o+r:a,height:t?t.scale.bandwidth()+i+s:c,facet:{width:a,height:c}}}function eE(e,t){if(e.range===void 0){let{insetLeft:n,insetRight:i}=e,{width:r,marginLeft:s=0,marginRight:o=0}=t,a=s+n,c=r-o-i;e.range=[a,Math.max(a,c)],yr(e)||(e.range=cE(e)),e.scale.range(e.range)}aE(e)}function nE(e,t){if(e.range===void 0){let{insetTop:n,insetBottom:i}=e,{height:r,marginTop:s=0,marginBottom:o=0}=t,a=s+n,c=r-o-i;e.range=[Math.max(a,c),a],yr(e)?e.range.reverse():e.range=cE(e),e.scale.range(e.range)}aE(e)}function aE(e){e.round===void 0&&U5(e)&&N5(e)<=30&&e.scale.round(!0)}function N5({scale:e}){let t=e.domain().length,[n,i]=e.range(),r=e.paddingInner?e.paddingInner():1,s=e.paddingOuter?e.paddingOuter():e.padding(),o=t-r,a=Math.abs(i-n)/Math.max(1,o+s*2);return(a-Math.floor(a))*o}function cE(e){let t=e.scale.domain().length+Ox(e);if(!(t>2))return e.range;let[n,i]=e.range;return Array.from({length:t},(r,s)=>n+s/(t-1)*(i-n))}function D5(e,t=[],n={}){let i=F5(e,t,n);if(n.type===void 0&&n.domain===void 0&&n.range===void 0&&n.interval==null&&e!=="fx"&&e!=="fy"&&yr({type:i})){let r=t.map(({value:s})=>s).filter(s=>s!==void 0);r.some(Ne)?Hn(`Warning: some data associated with the ${e} scale are dates. Dates are typically associated with a "utc" or "time" scale rather than a "${ja(i)}" scale. If you are using a bar mark, you probably want a rect mark with the interval option instead; if you are using a group transform, you probably want a bin transform instead. If you want to treat this data as ordinal, you can specify the interval of the ${e} scale (e.g., d3.utcDay), or you can suppress this warning by setting the type of the ${e} scale to "${ja(i)}".`):r.some(YT)?Hn(`Warning: some data associated with the ${e} scale are strings that appear to be dates (e.g., YYYY-MM-DD). If these strings represent dates, you should parse them to Date objects. Dates are typically associated with a "utc" or "time" scale rather than a "${ja(i)}" scale. If you are using a bar mark, you probably want a rect mark with the interval option instead; if you are using a group transform, you probably want a bin transform instead. If you want to treat this data as ordinal, you can suppress this warning by setting the type of the ${e} scale to "${ja(i)}".`):r.some(ZT)&&Hn(`Warning: some data associated with the ${e} scale are strings that appear to be numbers. If these strings represent numbers, you should parse or coerce them to numbers. Numbers are typically associated with a "linear" scale rather than a "${ja(i)}" scale. If you want to treat this data as ordinal, you can specify the interval of the ${e} scale (e.g., 1 for integers), or you can suppress this warning by setting the type of the ${e} scale to "${ja(i)}".`)}switch(n.type=i,i){case"diverging":case"diverging-sqrt":case"diverging-pow":case"diverging-log":case"diverging-symlog":case"cyclical":case"sequential":case"linear":case"sqrt":case"threshold":case"quantile":case"pow":case"log":case"symlog":n=Rd(t,n,dr);break;case"identity":switch(me.get(e)){case bi:n=Rd(t,n,dr);break;case $a:n=Rd(t,n,O5);break}break;case"utc":case"time":n=Rd(t,n,sx);break}switch(i){case"diverging":return GA(e,t,n);case"diverging-sqrt":return VA(e,t,n);case"diverging-pow":return Nx(e,t,n);case"diverging-log":return HA(e,t,n);case"diverging-symlog":return WA(e,t,n);case"categorical":case"ordinal":case Ka:return JA(e,t,n);case"cyclical":case"sequential":case"linear":return LA(e,t,n);case"sqrt":return NA(e,t,n);case"threshold":return Ed(e,t,n);case"quantile":return UA(e,t,n);case"quantize":return OA(e,t,n);case"pow":return Ix(e,t,n);case"log":return DA(e,t,n);case"symlog":return FA(e,t,n);case"utc":return qA(e,t,n);case"time":return XA(e,t,n);case"point":return KA(e,t,n);case"band":return jA(e,t,n);case"identity":return BA(e);case void 0:return;default:throw new Error(`unknown scale type: ${i}`)}}function ja(e){return typeof e=="symbol"?e.description:e}function iE(e){return typeof e=="string"?`${e}`.toLowerCase():e}var rE={toString:()=>"projection"};function F5(e,t,{type:n,domain:i,range:r,scheme:s,pivot:o,projection:a}){if(n=iE(n),e==="fx"||e==="fy")return"band";(e==="x"||e==="y")&&a!=null&&(n=rE);for(let u of t){let h=iE(u.type);if(h!==void 0){if(n===void 0)n=h;else if(n!==h)throw new Error(`scale incompatible with channel: ${n} !== ${h}`)}}if(n===rE)return;if(n!==void 0)return n;if(i===void 0&&!t.some(({value:u})=>u!==void 0))return;let c=me.get(e);if(c===Ao)return"sqrt";if(c===Co||c===Eo)return"linear";if(c===$a)return"ordinal";let l=(i??r)?.length;if(l<2||l>2)return Dx(c);if(i!==void 0){if(hx(i))return Dx(c);if(Ne(i))return"utc"}else{let u=t.map(({value:h})=>h).filter(h=>h!==void 0);if(u.some(hx))return Dx(c);if(u.some(Ne))return"utc"}if(c===Qn){if(o!=null||RA(s))return"diverging";if(EA(s))return"categorical"}return"linear"}function Dx(e){switch(e){case bi:return"point";case Qn:return Ka;default:return"ordinal"}}function yr({type:e}){return e==="ordinal"||e==="point"||e==="band"||e===Ka}function Ox({type:e}){return e==="threshold"}function U5({type:e}){return e==="point"||e==="band"}function zi(e){if(e===void 0)return!0;let t=e.domain(),n=e(t[0]);for(let i=1,r=t.length;i<r;++i)if(e(t[i])-n)return!1;return!0}function Rd(e,{domain:t,...n},i){for(let r of e)r.value!==void 0&&(t===void 0&&(t=r.value?.domain),r.value=i(r.value));return{domain:t===void 0?t:i(t),...n}}function O5(e){return de(e,Xa)}function lE(e){return t=>{if(!me.has(t=`${t}`))throw new Error(`unknown scale: ${t}`);return e[t]}}function B5({scale:e,type:t,domain:n,range:i,interpolate:r,interval:s,transform:o,percent:a,pivot:c}){if(t==="identity")return{type:"identity",apply:u=>u,invert:u=>u};let l=e.unknown?e.unknown():void 0;return{type:t,domain:Rs(n),...i!==void 0&&{range:Rs(i)},...o!==void 0&&{transform:o},...a&&{percent:a},...l!==void 0&&{unknown:l},...s!==void 0&&{interval:s},...r!==void 0&&{interpolate:r},...e.clamp&&{clamp:e.clamp()},...c!==void 0&&{pivot:c,symmetric:!1},...e.base&&{base:e.base()},...e.exponent&&{exponent:e.exponent()},...e.constant&&{constant:e.constant()},...e.align&&{align:e.align(),round:e.round()},...e.padding&&(e.paddingInner?{paddingInner:e.paddingInner(),paddingOuter:e.paddingOuter()}:{padding:e.padding()}),...e.bandwidth&&{bandwidth:e.bandwidth(),step:e.step()},apply:u=>e(u),...e.invert&&{invert:u=>e.invert(u)}}}function fE(e,t){let{fx:n,fy:i}=Wl(e,t),r=n?.scale.domain(),s=i?.scale.domain();return r&&s?m1(r,s).map(([o,a],c)=>({x:o,y:a,i:c})):r?r.map((o,a)=>({x:o,i:a})):s?s.map((o,a)=>({y:o,i:a})):void 0}function hE(e,{x:t,y:n}){return t&&=Vx(t),n&&=Vx(n),e.filter(t&&n?i=>t.has(i.x)&&n.has(i.y):t?i=>t.has(i.x):i=>n.has(i.y)).sort(t&&n?(i,r)=>t.get(i.x)-t.get(r.x)||n.get(i.y)-n.get(r.y):t?(i,r)=>t.get(i.x)-t.get(r.x):(i,r)=>n.get(i.y)-n.get(r.y))}function Ld(e,{fx:t,fy:n}){let i=Pn(e),r=t?.value,s=n?.value;return t&&n?Br(i,o=>(o.fx=r[o[0]],o.fy=s[o[0]],o),o=>r[o],o=>s[o]):t?Br(i,o=>(o.fx=r[o[0]],o),o=>r[o]):Br(i,o=>(o.fy=s[o[0]],o),o=>s[o])}function dE(e,t,{marginTop:n,marginLeft:i}){let r=e?({x:o})=>e(o)-i:()=>0,s=t?({y:o})=>t(o)-n:()=>0;return function(o){this.tagName==="svg"?(this.setAttribute("x",r(o)),this.setAttribute("y",s(o))):this.setAttribute("transform",`translate(${r(o)},${s(o)})`)}}function pE(e){let t=[],n=new Uint32Array(Li(e,i=>i.length));for(let i of e){let r=0;for(let s of e)i!==s&&(n.set(s,r),r+=s.length);t.push(n.slice(0,r))}return t}var k5=new Map([["top",Bx],["right",Gx],["bottom",kx],["left",zx],["top-left",Pd(Bx,zx)],["top-right",Pd(Bx,Gx)],["bottom-left",Pd(kx,zx)],["bottom-right",Pd(kx,Gx)],["top-empty",G5],["right-empty",W5],["bottom-empty",V5],["left-empty",H5],["empty",$5]]);function mE(e){if(e==null)return null;let t=k5.get(`${e}`.toLowerCase());if(t)return t;throw new Error(`invalid facet anchor: ${e}`)}var uE=new WeakMap;function Vx(e){let t=uE.get(e);return t||uE.set(e,t=new ai(de(e,(n,i)=>[n,i]))),t}function Ds(e,t){return Vx(e).get(t)}function z5(e,t,n){return t=_i(t),n=_i(n),e.find(i=>Object.is(_i(i.x),t)&&Object.is(_i(i.y),n))}function Nd(e,t,n){return z5(e,t,n)?.empty}function Bx(e,{y:t},{y:n}){return t?Ds(t,n)===0:!0}function kx(e,{y:t},{y:n}){return t?Ds(t,n)===t.length-1:!0}function zx(e,{x:t},{x:n}){return t?Ds(t,n)===0:!0}function Gx(e,{x:t},{x:n}){return t?Ds(t,n)===t.length-1:!0}function G5(e,{y:t},{x:n,y:i,empty:r}){if(r)return!1;if(!t)return;let s=Ds(t,i);if(s>0)return Nd(e,n,t[s-1])}function V5(e,{y:t},{x:n,y:i,empty:r}){if(r)return!1;if(!t)return;let s=Ds(t,i);if(s<t.length-1)return Nd(e,n,t[s+1])}function H5(e,{x:t},{x:n,y:i,empty:r}){if(r)return!1;if(!t)return;let s=Ds(t,n);if(s>0)return Nd(e,t[s-1],i)}function W5(e,{x:t},{x:n,y:i,empty:r}){if(r)return!1;if(!t)return;let s=Ds(t,n);if(s<t.length-1)return Nd(e,t[s+1],i)}function $5(e,t,{empty:n}){return n}function Pd(e,t){return function(){return e.apply(null,arguments)&&t.apply(null,arguments)}}function Dd(e,{channels:{fx:t,fy:n},groups:i}){return t&&n?e.map(({x:r,y:s})=>i.get(r)?.get(s)??[]):t?e.map(({x:r})=>i.get(r)??[]):e.map(({y:r})=>i.get(r)??[])}var gE=Math.PI,ts=2*gE,Hx=.618;function yE({projection:e,inset:t=0,insetTop:n=t,insetRight:i=t,insetBottom:r=t,insetLeft:s=t}={},o){if(e==null)return;if(typeof e.stream=="function")return e;let a,c,l="frame";if(Oi(e)){let w;if({type:e,domain:c,inset:w,insetTop:n=w!==void 0?w:n,insetRight:i=w!==void 0?w:i,insetBottom:r=w!==void 0?w:r,insetLeft:s=w!==void 0?w:s,clip:l=l,...a}=e,e==null)return}typeof e!="function"&&({type:e}=Wx(e));let{width:u,height:h,marginLeft:f,marginRight:d,marginTop:p,marginBottom:y}=o,m=u-f-d-s-i,g=h-p-y-n-r;if(e=e?.({width:m,height:g,clip:l,...a}),e==null)return;l=X5(l,f,p,u-d,h-y);let v=f+s,S=p+n,_;if(c!=null){let[[w,b],[x,M]]=_l(e).bounds(c),R=Math.min(m/(x-w),g/(M-b));R>0?(v-=(R*(w+x)-m)/2,S-=(R*(b+M)-g)/2,_=vl({point(E,C){this.stream.point(E*R+v,C*R+S)}})):Hn("Warning: the projection could not be fit to the specified domain; using the default scale.")}return _??=v===0&&S===0?xE():vl({point(w,b){this.stream.point(w+v,b+S)}}),{stream:w=>e.stream(_.stream(l(w)))}}function Wx(e){switch(`${e}`.toLowerCase()){case"albers-usa":return Gi(SS,.7463,.4673);case"albers":return Fd($g,.7463,.4673);case"azimuthal-equal-area":return Gi(AS,4,4);case"azimuthal-equidistant":return Gi(CS,ts,ts);case"conic-conformal":return Fd(PS,ts,ts);case"conic-equal-area":return Fd(xl,6.1702,2.9781);case"conic-equidistant":return Fd(NS,7.312,3.6282);case"equal-earth":return Gi(FS,5.4133,2.6347);case"equirectangular":return Gi(LS,ts,gE);case"gnomonic":return Gi(OS,3.4641,3.4641);case"identity":return{type:xE};case"reflect-y":return{type:q5};case"mercator":return Gi(RS,ts,ts);case"orthographic":return Gi(kS,2,2);case"stereographic":return Gi(GS,2,2);case"transverse-mercator":return Gi(HS,ts,ts);default:throw new Error(`unknown projection type: ${e}`)}}function X5(e,t,n,i,r){if(e===!1||e==null||typeof e=="number")return s=>s;if(e===!0&&(e="frame"),`${e}`.toLowerCase()==="frame")return Gg(t,n,i,r);throw new Error(`unknown projection clip type: ${e}`)}function Gi(e,t,n){return{type:({width:i,height:r,rotate:s,precision:o=.15,clip:a})=>{let c=e();return o!=null&&c.precision?.(o),s!=null&&c.rotate?.(s),typeof a=="number"&&c.clipAngle?.(a),i!=null&&(c.scale(Math.min(i/t,r/n)),c.translate([i/2,r/2])),c},aspectRatio:n/t}}function Fd(e,t,n){let{type:i,aspectRatio:r}=Gi(e,t,n);return{type:s=>{let{parallels:o,domain:a,width:c,height:l}=s,u=i(s);return o!=null&&(u.parallels(o),a===void 0&&c!=null&&u.fitSize([c,l],{type:"Sphere"})),u},aspectRatio:r}}var xE=jn({stream:e=>e}),q5=jn(vl({point(e,t){this.stream.point(e,-t)}}));function _E(e,t,n,i){let r=n[e],s=n[t],o=r.length,a=n[e]=new Float64Array(o).fill(NaN),c=n[t]=new Float64Array(o).fill(NaN),l,u=i.stream({point(h,f){a[l]=h,c[l]=f}});for(l=0;l<o;++l)u.point(r[l],s[l])}function vE({projection:e}={}){return e==null?!1:typeof e.stream=="function"?!0:(Oi(e)&&(e=e.type),e!=null)}function bE(e){if(typeof e?.stream=="function")return Hx;if(Oi(e)){let t,n;if({domain:t,type:e,...n}=e,t!=null&&e!=null){let i=typeof e=="string"?Wx(e).type:e,[[r,s],[o,a]]=_l(i({...n,width:100,height:100})).bounds(t),c=(a-s)/(o-r);return c&&isFinite(c)?c<.2?.2:c>5?5:c:Hx}}if(e!=null){if(typeof e!="function"){let{aspectRatio:t}=Wx(e);if(t)return t}return Hx}}function ME(e){let t=[],n=[],i={scale:"x",value:t},r={scale:"y",value:n},s={point(o,a){t.push(o),n.push(a)},lineStart(){},lineEnd(){},polygonStart(){},polygonEnd(){},sphere(){}};for(let o of e.value)Ss(o,s);return[i,r]}function SE({x:e,y:t}){if(e||t)return e??=n=>n,t??=n=>n,vl({point(n,i){this.stream.point(e(n),t(i))}})}function Qa(e={}){let{document:t=typeof window<"u"?window.document:void 0,clip:n}=e;return{document:t,clip:Td(n)}}function se(e,{document:t}){return Ni(xa(e).call(t.documentElement))}var Ud=Symbol("unset");function Od(e){return(e.length===1?Y5:Z5)(e)}function Y5(e){let t,n=Ud;return i=>(Object.is(n,i)||(n=i,t=e(i)),t)}function Z5(e){let t,n;return(...i)=>((n?.length!==i.length||n.some((r,s)=>!Object.is(r,i[s])))&&(n=i,t=e(...i)),t)}var J5=Od(e=>new Intl.NumberFormat(e)),wW=Od((e,t)=>new Intl.DateTimeFormat(e,{timeZone:"UTC",...t&&{month:t}})),TW=Od((e,t)=>new Intl.DateTimeFormat(e,{timeZone:"UTC",...t&&{weekday:t}}));function K5(e="en-US"){let t=J5(e);return n=>n!=null&&!isNaN(n)?t.format(n):void 0}function j5(e){return md(e,"Invalid Date")}function Q5(e="en-US"){let t=K5(e);return n=>(n instanceof Date?j5:typeof n=="number"?t:De)(n)}var xr=Q5();var ln=(typeof window<"u"?window.devicePixelRatio>1:typeof it>"u")?0:.5,tB=0;function TE(){return`plot-clip-${++tB}`}function AE(e,{title:t,href:n,ariaLabel:i,ariaDescription:r,ariaHidden:s,target:o,fill:a,fillOpacity:c,stroke:l,strokeWidth:u,strokeOpacity:h,strokeLinejoin:f,strokeLinecap:d,strokeMiterlimit:p,strokeDasharray:y,strokeDashoffset:m,opacity:g,mixBlendMode:v,imageFilter:S,paintOrder:_,pointerEvents:w,shapeRendering:b,channels:x},{ariaLabel:M,fill:R="currentColor",fillOpacity:E,stroke:C="none",strokeOpacity:N,strokeWidth:B,strokeLinecap:I,strokeLinejoin:L,strokeMiterlimit:k,paintOrder:F}){R===null&&(a=null,c=null),C===null&&(l=null,h=null),rn(R)?!rn(C)&&(!rn(a)||x?.fill)&&(C="none"):rn(C)&&(!rn(l)||x?.stroke)&&(R="none");let[Z,U]=Gn(a,R),[G,q]=Pe(c,E),[st,ct]=Gn(l,C),[$,at]=Pe(h,N),[ft,ot]=Pe(g);To(ct)||(u===void 0&&(u=B),d===void 0&&(d=I),f===void 0&&(f=L),p===void 0&&!jT(f)&&(p=k),!To(U)&&_===void 0&&(_=F));let[rt,J]=Pe(u);return R!==null&&(e.fill=Le(U,"currentColor"),e.fillOpacity=$l(q,1)),C!==null&&(e.stroke=Le(ct,"none"),e.strokeWidth=$l(J,1),e.strokeOpacity=$l(at,1),e.strokeLinejoin=Le(f,"miter"),e.strokeLinecap=Le(d,"butt"),e.strokeMiterlimit=$l(p,4),e.strokeDasharray=Le(y,"none"),e.strokeDashoffset=Le(m,"0")),e.target=De(o),e.ariaLabel=De(M),e.ariaDescription=De(r),e.ariaHidden=De(s),e.opacity=$l(ot,1),e.mixBlendMode=Le(v,"normal"),e.imageFilter=Le(S,"none"),e.paintOrder=Le(_,"normal"),e.pointerEvents=Le(w,"auto"),e.shapeRendering=Le(b,"auto"),{title:{value:t,optional:!0,filter:null},href:{value:n,optional:!0,filter:null},ariaLabel:{value:i,optional:!0,filter:null},fill:{value:Z,scale:"auto",optional:!0},fillOpacity:{value:G,scale:"auto",optional:!0},stroke:{value:st,scale:"auto",optional:!0},strokeOpacity:{value:$,scale:"auto",optional:!0},strokeWidth:{value:rt,optional:!0},opacity:{value:ft,scale:"auto",optional:!0}}}function eB(e,t){t&&e.filter(n=>Nl(t[n])).append("title").call(iB,t)}function nB(e,t){t&&e.filter(([n])=>Nl(t[n])).append("title").call(rB,t)}function iB(e,t){t&&e.text(n=>xr(t[n]))}function rB(e,t){t&&e.text(([n])=>xr(t[n]))}function un(e,{target:t,tip:n},{ariaLabel:i,title:r,fill:s,fillOpacity:o,stroke:a,strokeOpacity:c,strokeWidth:l,opacity:u,href:h}){i&&Ot(e,"aria-label",f=>i[f]),s&&Ot(e,"fill",f=>s[f]),o&&Ot(e,"fill-opacity",f=>o[f]),a&&Ot(e,"stroke",f=>a[f]),c&&Ot(e,"stroke-opacity",f=>c[f]),l&&Ot(e,"stroke-width",f=>l[f]),u&&Ot(e,"opacity",f=>u[f]),h&&EE(e,f=>h[f],t),n||eB(e,r)}function Bd(e,{target:t,tip:n},{ariaLabel:i,title:r,fill:s,fillOpacity:o,stroke:a,strokeOpacity:c,strokeWidth:l,opacity:u,href:h}){i&&Ot(e,"aria-label",([f])=>i[f]),s&&Ot(e,"fill",([f])=>s[f]),o&&Ot(e,"fill-opacity",([f])=>o[f]),a&&Ot(e,"stroke",([f])=>a[f]),c&&Ot(e,"stroke-opacity",([f])=>c[f]),l&&Ot(e,"stroke-width",([f])=>l[f]),u&&Ot(e,"opacity",([f])=>u[f]),h&&EE(e,([f])=>h[f],t),n||nB(e,r)}function sB({ariaLabel:e,title:t,fill:n,fillOpacity:i,stroke:r,strokeOpacity:s,strokeWidth:o,opacity:a,href:c},{tip:l}){return[e,l?void 0:t,n,i,r,s,o,a,c].filter(u=>u!==void 0)}function oB(e,t,n){let i=to(e,r=>t[r]);return n===void 0&&i.size>1+e.length>>1&&Hn("Warning: the implicit z channel has high cardinality. This may occur when the fill or stroke channel is associated with quantitative data rather than ordinal or categorical data. You can suppress this warning by setting the z option explicitly; if this data represents a single series, set z to null."),i.values()}function*kd(e,t,n,i){let{z:r}=n,{z:s}=i,o=sB(i,n),a=[...t,...o];for(let c of s?oB(e,s,r):[e]){let l,u;t:for(let h of c){for(let f of a)if(!xi(f[h])){u&&u.push(-1);continue t}if(l===void 0){u&&(yield u),l=o.map(f=>_i(f[h])),u=[h];continue}u.push(h);for(let f=0;f<o.length;++f)if(_i(o[f][h])!==l[f]){yield u,l=o.map(p=>_i(p[h])),u=[h];continue t}}u&&(yield u)}}function aB(e,t,n,i){let r,{clip:s=i.clip}=t;s==="frame"?(e=se("svg:g",i).each(function(){this.appendChild(e.node()),e.node=()=>this}),r=lB(i,n)):s&&(r=fB(s,i)),Ot(e,"aria-label",t.ariaLabel),Ot(e,"aria-description",t.ariaDescription),Ot(e,"aria-hidden",t.ariaHidden),Ot(e,"clip-path",r)}function cB(e){let t=new WeakMap;return(n,i)=>{let r=t.get(n);if(!r){let s=TE();Ni(n.ownerSVGElement).append("clipPath").attr("id",s).call(e,n,i),t.set(n,r=`url(#${s})`)}return r}}var lB=cB((e,t,n)=>{let{width:i,height:r,marginLeft:s,marginRight:o,marginTop:a,marginBottom:c}=n;e.append("rect").attr("x",s).attr("y",a).attr("width",i-o-s).attr("height",r-a-c)}),wE=new WeakMap,uB={type:"Sphere"};function fB(e,t){let n,i;if((n=wE.get(t))||wE.set(t,n=new WeakMap),e.type==="Sphere"&&(e=uB),!(i=n.get(e))){let r=TE();Ni(t.ownerSVGElement).append("clipPath").attr("id",r).append("path").attr("d",t.path()(e)),n.set(e,i=`url(#${r})`)}return i}function Ue(e,t,n,i){aB(e,t,n,i),Ot(e,"class",t.className),Ot(e,"fill",t.fill),Ot(e,"fill-opacity",t.fillOpacity),Ot(e,"stroke",t.stroke),Ot(e,"stroke-width",t.strokeWidth),Ot(e,"stroke-opacity",t.strokeOpacity),Ot(e,"stroke-linejoin",t.strokeLinejoin),Ot(e,"stroke-linecap",t.strokeLinecap),Ot(e,"stroke-miterlimit",t.strokeMiterlimit),Ot(e,"stroke-dasharray",t.strokeDasharray),Ot(e,"stroke-dashoffset",t.strokeDashoffset),Ot(e,"shape-rendering",t.shapeRendering),Ot(e,"filter",t.imageFilter),Ot(e,"paint-order",t.paintOrder);let{pointerEvents:r=i.pointerSticky===!1?"none":void 0}=t;Ot(e,"pointer-events",r)}function Ee(e,t){hB(e,"mix-blend-mode",t.mixBlendMode),Ot(e,"opacity",t.opacity)}function EE(e,t,n){e.each(function(i){let r=t(i);if(r!=null){let s=this.ownerDocument.createElementNS(vs.svg,"a");s.setAttribute("fill","inherit"),s.setAttributeNS(vs.xlink,"href",r),n!=null&&s.setAttribute("target",n),this.parentNode.insertBefore(s,this).appendChild(this)}})}function Ot(e,t,n){n!=null&&e.attr(t,n)}function hB(e,t,n){n!=null&&e.style(t,n)}function Oe(e,t,{x:n,y:i},r=ln,s=ln){r+=t.dx,s+=t.dy,n?.bandwidth&&(r+=n.bandwidth()/2),i?.bandwidth&&(s+=i.bandwidth()/2),(r||s)&&e.attr("transform",`translate(${r},${s})`)}function Le(e,t){if((e=De(e))!==t)return e}function $l(e,t){if((e=Fe(e))!==t)return e}var dB=/^-?([_a-z]|[\240-\377]|\\[0-9a-f]{1,6}(\r\n|[ \t\r\n\f])?|\\[^\r\n\f0-9a-f])([_a-z0-9-]|[\240-\377]|\\[0-9a-f]{1,6}(\r\n|[ \t\r\n\f])?|\\[^\r\n\f0-9a-f])*$/i;function tc(e){if(e===void 0)return"plot-d6a7b5";if(e=`${e}`,!dB.test(e))throw new Error(`invalid class name: ${e}`);return e}function ec(e,t){if(typeof t=="string")e.property("style",t);else if(t!=null)for(let n of e)Object.assign(n.style,t)}function _r({frameAnchor:e},{width:t,height:n,marginTop:i,marginRight:r,marginBottom:s,marginLeft:o}){return[/left$/.test(e)?o:/right$/.test(e)?t-r:(o+t-r)/2,/^top/.test(e)?i:/^bottom/.test(e)?n-s:(i+n-s)/2]}var ge=class{constructor(t,n={},i={},r){let{facet:s="auto",facetAnchor:o,fx:a,fy:c,sort:l,dx:u=0,dy:h=0,margin:f=0,marginTop:d=f,marginRight:p=f,marginBottom:y=f,marginLeft:m=f,className:g,clip:v=r?.clip,channels:S,tip:_,render:w}=i;if(this.data=t,this.sort=Is(l)?l:null,this.initializer=Jr(i).initializer,this.transform=this.initializer?i.transform:Ro(i).transform,s===null||s===!1?this.facet=null:(this.facet=In(s===!0?"include":s,"facet",["auto","include","exclude","super"]),this.fx=t===Ba&&typeof a=="string"?[a]:a,this.fy=t===Ba&&typeof c=="string"?[c]:c),this.facetAnchor=mE(o),n=dx(n),S!==void 0&&(n={...pB(S),...n}),r!==void 0&&(n={...AE(this,i,r),...n}),this.channels=Object.fromEntries(Object.entries(n).map(([b,x])=>{if(za(x.value)){let{value:M,label:R=x.label,scale:E=x.scale}=x.value;x={...x,label:R,scale:E,value:M}}if(t===Ba&&typeof x.value=="string"){let{value:M}=x;x={...x,value:[M]}}return[b,x]}).filter(([b,{value:x,optional:M}])=>{if(x!=null)return!0;if(M)return!1;throw new Error(`missing channel value: ${b}`)})),this.dx=+u,this.dy=+h,this.marginTop=+d,this.marginRight=+p,this.marginBottom=+y,this.marginLeft=+m,this.clip=Td(v),this.tip=mB(_),this.className=De(g),this.facet==="super"){if(a||c)throw new Error("super-faceting cannot use fx or fy");for(let b in this.channels){let{scale:x}=n[b];if(!(x!=="x"&&x!=="y"))throw new Error("super-faceting cannot use x or y")}}w!=null&&(this.render=Xx(w,this.render))}initialize(t,n,i){let r=Zr(this.data);t===void 0&&r!=null&&(t=[Pn(r)]);let s=t;this.transform!=null&&({facets:t,data:r}=this.transform(r,t,i),r=Zr(r)),t!==void 0&&(t.original=s);let o=yA(this.channels,r);return this.sort!=null&&_A(r,t,o,n,this.sort),{data:r,facets:t,channels:o}}filter(t,n,i){for(let r in n){let{filter:s=xi}=n[r];if(s!==null){let o=i[r];t=t.filter(a=>s(o[a]))}}return t}project(t,n,i){for(let r in t)if(t[r].scale==="x"&&/^x|x$/.test(r)){let s=r.replace(/^x|x$/,"y");s in t&&t[s].scale==="y"&&_E(r,s,n,i.projection)}}scale(t,n,i){let r=xA(t,n);return i.projection&&this.project(t,r,i),r}};function $x(...e){return e.plot=ge.prototype.plot,e}function Xx(e,t){if(e==null)return t===null?void 0:t;if(t==null)return e===null?void 0:e;if(typeof e!="function")throw new TypeError(`invalid render transform: ${e}`);if(typeof t!="function")throw new TypeError(`invalid render transform: ${t}`);return function(n,i,r,s,o,a){return e.call(this,n,i,r,s,o,(c,l,u,h,f)=>t.call(this,c,l,u,h,f,a))}}function pB(e){return Object.fromEntries(Object.entries(dx(e)).map(([t,n])=>(n=typeof n=="string"?{value:n,label:t}:gr(n),n.filter===void 0&&n.scale==null&&(n={...n,filter:null}),[t,n])))}function mB(e){return e===!0?"xy":e===!1||e==null?null:typeof e=="string"?In(e,"tip",["x","y","xy"]):e}function Fs(e,t){return e?.tip===!0?{...e,tip:t}:Oi(e?.tip)&&e.tip.pointer===void 0?{...e,tip:{...e.tip,pointer:t}}:e}function RE(e,t,n={}){let i=.5-ln,r=.5+ln,s=.5+ln,o=.5-ln;for(let{marginTop:y,marginRight:m,marginBottom:g,marginLeft:v}of t)y>i&&(i=y),m>r&&(r=m),g>s&&(s=g),v>o&&(o=v);let{margin:a,marginTop:c=a!==void 0?a:i,marginRight:l=a!==void 0?a:r,marginBottom:u=a!==void 0?a:s,marginLeft:h=a!==void 0?a:o}=n;c=+c,l=+l,u=+u,h=+h;let{width:f=640,height:d=gB(e,n,{width:f,marginTopDefault:i,marginRightDefault:r,marginBottomDefault:s,marginLeftDefault:o})+Math.max(0,c-i+u-s)}=n;f=+f,d=+d;let p={width:f,height:d,marginTop:c,marginRight:l,marginBottom:u,marginLeft:h};if(e.fx||e.fy){let{margin:y,marginTop:m=y!==void 0?y:c,marginRight:g=y!==void 0?y:l,marginBottom:v=y!==void 0?y:u,marginLeft:S=y!==void 0?y:h}=n.facet??{};m=+m,g=+g,v=+v,S=+S,p.facet={marginTop:m,marginRight:g,marginBottom:v,marginLeft:S}}return p}function gB({x:e,y:t,fy:n,fx:i},{projection:r,aspectRatio:s},{width:o,marginTopDefault:a,marginRightDefault:c,marginBottomDefault:l,marginLeftDefault:u}){let h=n&&n.scale.domain().length||1,f=bE(r);if(f){let p=i?i.scale.domain().length:1,y=(1.1*h-.1)/(1.1*p-.1)*f,m=Math.max(.1,Math.min(10,y));return Math.round((o-u-c)*m+a+l)}let d=t?yr(t)?t.scale.domain().length||1:Math.max(7,17/h):1;if(s!=null){if(s=+s,!(isFinite(s)&&s>0))throw new Error(`invalid aspectRatio: ${s}`);let p=CE("y",t)/(CE("x",e)*s),y=i?i.scale.bandwidth():1,m=n?n.scale.bandwidth():1,g=y*(o-u-c)-e.insetLeft-e.insetRight;return(p*g+t.insetTop+t.insetBottom)/m+a+l}return!!(t||n)*Math.max(1,Math.min(60,d*h))*20+!!i*30+60}function CE(e,t){if(!t)throw new Error(`aspectRatio requires ${e} scale`);let{type:n,domain:i}=t,r;switch(n){case"linear":case"utc":case"time":r=Number;break;case"pow":{let a=t.scale.exponent();r=c=>Math.pow(c,a);break}case"log":r=Math.log;break;case"point":case"band":return i.length;default:throw new Error(`unsupported ${e} scale for aspectRatio: ${n}`)}let[s,o]=cn(i);return Math.abs(r(o)-r(s))}var IE=new WeakMap;function qx(e,t,{x:n,y:i,px:r,py:s,maxRadius:o=40,channels:a,render:c,...l}={}){return o=+o,r!=null&&(n??=null,a={...a,px:{value:r,scale:"x"}}),s!=null&&(i??=null,a={...a,py:{value:s,scale:"y"}}),{x:n,y:i,channels:a,...l,render:Xx(function(u,h,f,d,p,y){p={...p,pointerSticky:!1};let m=p.ownerSVGElement,{data:g}=p.getMarkState(this),v=IE.get(m);v||IE.set(m,v={sticky:!1,roots:[],renders:[]});let S=v.renders.push(ct)-1,{x:_,y:w,fx:b,fy:x}=h,M=b?b(u.fx)-d.marginLeft:0,R=x?x(u.fy)-d.marginTop:0;_?.bandwidth&&(M+=_.bandwidth()/2),w?.bandwidth&&(R+=w.bandwidth()/2);let E=u.fi!=null,C;if(E){let ot=v.facetStates;ot||(v.facetStates=ot=new Map),C=ot.get(this),C||ot.set(this,C=new Map)}let[N,B]=_r(this,d),{px:I,py:L}=f,k=I?ot=>I[ot]:Zx(f,N),F=L?ot=>L[ot]:Jx(f,B),Z,U,G,q;function st(ot,rt){if(E)if(q&&(q=cancelAnimationFrame(q)),ot==null)C.delete(u.fi);else{C.set(u.fi,rt),q=requestAnimationFrame(()=>{q=null;for(let[J,gt]of C)if(gt<rt||gt===rt&&J<u.fi){ot=null;break}ct(ot)});return}ct(ot)}function ct(ot){if(Z===ot&&G===v.sticky)return;Z=ot,G=p.pointerSticky=v.sticky;let rt=Z==null?[]:[Z];E&&(rt.fx=u.fx,rt.fy=u.fy,rt.fi=u.fi);let J=y(rt,h,f,d,p);if(U){if(E){let gt=U.parentNode,lt=U.getAttribute("transform"),K=J.getAttribute("transform");lt?J.setAttribute("transform",lt):J.removeAttribute("transform"),K?gt.setAttribute("transform",K):gt.removeAttribute("transform"),J.removeAttribute("aria-label"),J.removeAttribute("aria-description"),J.removeAttribute("aria-hidden")}U.replaceWith(J)}if(v.roots[S]=U=J,!(Z==null&&C?.size>1)){let gt=Z==null?null:Ui(g)?g[Z]:g.get(Z);p.dispatchValue(gt)}return J}function $(ot){if(v.sticky||ot.pointerType==="mouse"&&ot.buttons===1)return;let[rt,J]=W1(ot);rt-=M,J-=R;let gt=rt<d.marginLeft||rt>d.width-d.marginRight?1:e,lt=J<d.marginTop||J>d.height-d.marginBottom?1:t,K=null,It=o*o;for(let pt of u){let Ut=gt*(k(pt)-rt),Gt=lt*(F(pt)-J),ce=Ut*Ut+Gt*Gt;ce<=It&&(K=pt,It=ce)}if(K!=null&&(e!==1||t!==1)){let pt=k(K)-rt,Ut=F(K)-J;It=pt*pt+Ut*Ut}st(K,It)}function at(ot){ot.pointerType==="mouse"&&Z!=null&&(v.sticky&&v.roots.some(rt=>rt?.contains(ot.target))||(v.sticky?(v.sticky=!1,v.renders.forEach(rt=>rt(null))):(v.sticky=!0,ct(Z)),ot.stopImmediatePropagation()))}function ft(ot){ot.pointerType==="mouse"&&(v.sticky||st(null))}return m.addEventListener("pointerenter",$),m.addEventListener("pointermove",$),m.addEventListener("pointerdown",at),m.addEventListener("pointerleave",ft),ct(null)},c)}}function PE(e){return qx(1,1,e)}function LE(e){return qx(1,.01,e)}function Yx(e){return qx(.01,1,e)}function Zx({x1:e,x2:t,x:n=e},i){return e&&t?r=>(e[r]+t[r])/2:n?r=>n[r]:()=>i}function Jx({y1:e,y2:t,y:n=e},i){return e&&t?r=>(e[r]+t[r])/2:n?r=>n[r]:()=>i}function zd(e){return yr(e)&&e.interval===void 0?void 0:"tabular-nums"}function NE(e,t){let{label:n=e.label,tickSize:i=6,width:r=240,height:s=44+i,marginTop:o=18,marginRight:a=0,marginBottom:c=16+i,marginLeft:l=0,style:u,ticks:h=(r-l-a)/64,tickFormat:f,fontVariant:d=zd(e),round:p=!0,opacity:y,className:m}=t,g=Qa(t);m=tc(m),y=Pe(y)[1],f===null&&(f=()=>null);let v=se("svg",g).attr("class",`${m}-ramp`).attr("font-family","system-ui, sans-serif").attr("font-size",10).attr("width",r).attr("height",s).attr("viewBox",`0 0 ${r} ${s}`).call(N=>N.append("style").text(`:where(.${m}-ramp) {
  display: block;
  height: auto;
  height: intrinsic;
  max-width: 100%;
  overflow: visible;
}
:where(.${m}-ramp text) {
  white-space: pre;
}`)).call(ec,u),S=N=>N.selectAll(".tick line").attr("y1",o+c-s),_,w=p?(N,B)=>N.rangeRound(B):(N,B)=>N.range(B),{type:b,domain:x,range:M,interpolate:R,scale:E,pivot:C}=e;if(R){let N=M===void 0?R:Ms(R.length===1?Hl(R):R,M);_=w(E.copy(),En(He(l,r-a),Math.min(x.length+(C!==void 0),M===void 0?1/0:M.length)));let B=256,I=g.document.createElement("canvas");I.width=B,I.height=1;let L=I.getContext("2d");for(let k=0,F=B-1;k<B;++k)L.fillStyle=N(k/F),L.fillRect(k,0,1,1);v.append("image").attr("opacity",y).attr("x",l).attr("y",o).attr("width",r-l-a).attr("height",s-o-c).attr("preserveAspectRatio","none").attr("xlink:href",I.toDataURL())}else if(b==="threshold"){let N=x,B=f===void 0?I=>I:typeof f=="string"?nr(f):f;_=w(Rl().domain([-1,M.length-1]),[l,r-a]),v.append("g").attr("fill-opacity",y).selectAll().data(M).enter().append("rect").attr("x",(I,L)=>_(L-1)).attr("y",o).attr("width",(I,L)=>_(L)-_(L-1)).attr("height",s-o-c).attr("fill",I=>I),h=de(N,(I,L)=>L),f=I=>B(N[I],I)}else _=w(Na().domain(x),[l,r-a]),v.append("g").attr("fill-opacity",y).selectAll().data(x).enter().append("rect").attr("x",_).attr("y",o).attr("width",Math.max(0,_.bandwidth()-1)).attr("height",s-o-c).attr("fill",E),S=()=>{};return v.append("g").attr("transform",`translate(0,${s-c})`).call(L1(_).ticks(Array.isArray(h)?null:h,typeof f=="string"?f:void 0).tickFormat(typeof f=="function"?f:void 0).tickSize(i).tickValues(Array.isArray(h)?h:null)).attr("font-size",null).attr("font-family",null).attr("font-variant",Le(d,"normal")).call(S).call(N=>N.select(".domain").remove()),n!==void 0&&v.append("text").attr("x",l).attr("y",o-6).attr("fill","currentColor").attr("font-weight","bold").text(n),v.node()}var Kx=Math.PI/180;function Xl(e,{marker:t,markerStart:n=t,markerMid:i=t,markerEnd:r=t}={}){e.markerStart=jx(n),e.markerMid=jx(i),e.markerEnd=jx(r)}function jx(e){if(e==null||e===!1)return null;if(e===!0)return FE;if(typeof e=="function")return e;switch(`${e}`.toLowerCase()){case"none":return null;case"arrow":return DE("auto");case"arrow-reverse":return DE("auto-start-reverse");case"dot":return yB;case"circle":case"circle-fill":return FE;case"circle-stroke":return xB;case"tick":return Qx("auto");case"tick-x":return Qx(90);case"tick-y":return Qx(0)}throw new Error(`invalid marker: ${e}`)}function DE(e){return(t,n)=>se("svg:marker",n).attr("viewBox","-5 -5 10 10").attr("markerWidth",6.67).attr("markerHeight",6.67).attr("orient",e).attr("fill","none").attr("stroke",t).attr("stroke-width",1.5).attr("stroke-linecap","round").attr("stroke-linejoin","round").call(i=>i.append("path").attr("d","M-1.5,-3l3,3l-3,3")).node()}function yB(e,t){return se("svg:marker",t).attr("viewBox","-5 -5 10 10").attr("markerWidth",6.67).attr("markerHeight",6.67).attr("fill",e).attr("stroke","none").call(n=>n.append("circle").attr("r",2.5)).node()}function FE(e,t){return se("svg:marker",t).attr("viewBox","-5 -5 10 10").attr("markerWidth",6.67).attr("markerHeight",6.67).attr("fill",e).attr("stroke","var(--plot-background)").attr("stroke-width",1.5).call(n=>n.append("circle").attr("r",3)).node()}function xB(e,t){return se("svg:marker",t).attr("viewBox","-5 -5 10 10").attr("markerWidth",6.67).attr("markerHeight",6.67).attr("fill","var(--plot-background)").attr("stroke",e).attr("stroke-width",1.5).call(n=>n.append("circle").attr("r",3)).node()}function Qx(e){return(t,n)=>se("svg:marker",n).attr("viewBox","-3 -3 6 6").attr("markerWidth",6).attr("markerHeight",6).attr("orient",e).attr("stroke",t).call(i=>i.append("path").attr("d","M0,-3v6")).node()}var _B=0;function e_(e,t,{stroke:n},i){return BE(e,t,n&&(r=>n[r]),null,i)}function UE(e,t,{stroke:n,z:i},r){return BE(e,t,n&&(([s])=>n[s]),i,r)}var t_=1,OE=2;function vB(e,t){let n=new Uint8Array(t.length),i=e.data().filter(s=>s.length>1),r=i.length;for(let s=0,o=Ud;s<r;++s){let a=i[s];if(a.length>1){let c=a[0];o!==(o=_i(t[c]))&&(n[c]|=t_)}}for(let s=r-1,o=Ud;s>=0;--s){let a=i[s];if(a.length>1){let c=a[0];o!==(o=_i(t[c]))&&(n[c]|=OE)}}return([s])=>n[s]}function BE(e,{markerStart:t,markerMid:n,markerEnd:i,stroke:r},s=()=>r,o,a){if(!t&&!n&&!i)return;let c=new Map,l=o&&vB(e,o);function u(h,f,d){return function(p){if(d&&!d(p))return;let y=s(p),m=c.get(f);m||c.set(f,m=new Map);let g=m.get(y);if(!g){let v=this.parentNode.insertBefore(f(y,a),this),S=`plot-marker-${++_B}`;v.setAttribute("id",S),m.set(y,g=`url(#${S})`)}this.setAttribute(h,g)}}t&&e.each(u("marker-start",t,l&&(h=>l(h)&t_))),n&&l&&e.each(u("marker-start",n,h=>!(l(h)&t_))),n&&e.each(u("marker-mid",n)),i&&e.each(u("marker-end",i,l&&(h=>l(h)&OE)))}function nc({inset:e,insetLeft:t,insetRight:n,...i}={}){return[t,n]=kE(e,t,n),{inset:e,insetLeft:t,insetRight:n,...i}}function ql({inset:e,insetTop:t,insetBottom:n,...i}={}){return[t,n]=kE(e,t,n),{inset:e,insetTop:t,insetBottom:n,...i}}function kE(e,t,n){return e===void 0&&t===void 0&&n===void 0?ln?[1,0]:[.5,.5]:[t,n]}function zE(e,{interval:t}){return e={...gr(e)},e.interval=bd(e.interval===void 0?t:e.interval),e}function Gd(e,t,n,i){let{[e]:r,[`${e}1`]:s,[`${e}2`]:o}=n,{value:a,interval:c}=zE(r,n);if(a==null||c==null&&!i)return n;let l=ki(r);if(c==null){let d,p={transform:y=>d||(d=Se(y,a)),label:l};return{...n,[e]:void 0,[`${e}1`]:s===void 0?p:s,[`${e}2`]:o===void 0&&!(s===o&&i)?p:o}}let u,h;function f(d){return h!==void 0&&d===u?h:h=de(Se(u=d,a),p=>c.floor(p))}return t({...n,[e]:void 0,[`${e}1`]:s===void 0?{transform:f,label:l}:s,[`${e}2`]:o===void 0?{transform:d=>f(d).map(p=>c.offset(p)),label:l}:o})}function GE(e,t,n){let{[e]:i}=n,{value:r,interval:s}=zE(i,n);return r==null||s==null?n:t({...n,[e]:{label:ki(i),transform:o=>{let a=de(Se(o,r),l=>s.floor(l)),c=a.map(l=>s.offset(l));return a.map(Ne(a)?(l,u)=>l==null||isNaN(l=+l)||(u=c[u],u==null)||isNaN(u=+u)?void 0:new Date((l+u)/2):(l,u)=>l==null||(u=c[u],u==null)?NaN:(+l+ +u)/2)}}})}function VE(e={}){return Gd("x",nc,e,!0)}function n_(e={}){return Gd("y",ql,e,!0)}function Vd(e={}){return Gd("x",nc,e)}function i_(e={}){return Gd("y",ql,e)}function HE(e={}){return GE("x",nc,e)}function WE(e={}){return GE("y",ql,e)}var $E={ariaLabel:"rule",fill:null,stroke:"currentColor"},Hd=class extends ge{constructor(t,n={}){let{x:i,y1:r,y2:s,inset:o=0,insetTop:a=o,insetBottom:c=o}=n;super(t,{x:{value:i,scale:"x",optional:!0},y1:{value:r,scale:"y",optional:!0},y2:{value:s,scale:"y",optional:!0}},Fs(n,"x"),$E),this.insetTop=Fe(a),this.insetBottom=Fe(c),Xl(this,n)}render(t,n,i,r,s){let{x:o,y:a}=n,{x:c,y1:l,y2:u}=i,{width:h,height:f,marginTop:d,marginRight:p,marginLeft:y,marginBottom:m}=r,{insetTop:g,insetBottom:v}=this;return se("svg:g",s).call(Ue,this,r,s).call(Oe,this,{x:c&&o},ln,0).call(S=>S.selectAll().data(t).enter().append("line").call(Ee,this).attr("x1",c?_=>c[_]:(y+h-p)/2).attr("x2",c?_=>c[_]:(y+h-p)/2).attr("y1",l&&!zi(a)?_=>l[_]+g:d+g).attr("y2",u&&!zi(a)?a.bandwidth?_=>u[_]+a.bandwidth()-v:_=>u[_]-v:f-m-v).call(un,this,i).call(e_,this,i,s)).node()}},Wd=class extends ge{constructor(t,n={}){let{x1:i,x2:r,y:s,inset:o=0,insetRight:a=o,insetLeft:c=o}=n;super(t,{y:{value:s,scale:"y",optional:!0},x1:{value:i,scale:"x",optional:!0},x2:{value:r,scale:"x",optional:!0}},Fs(n,"y"),$E),this.insetRight=Fe(a),this.insetLeft=Fe(c),Xl(this,n)}render(t,n,i,r,s){let{x:o,y:a}=n,{y:c,x1:l,x2:u}=i,{width:h,height:f,marginTop:d,marginRight:p,marginLeft:y,marginBottom:m}=r,{insetLeft:g,insetRight:v}=this;return se("svg:g",s).call(Ue,this,r,s).call(Oe,this,{y:c&&a},0,ln).call(S=>S.selectAll().data(t).enter().append("line").call(Ee,this).attr("x1",l&&!zi(o)?_=>l[_]+g:y+g).attr("x2",u&&!zi(o)?o.bandwidth?_=>u[_]+o.bandwidth()-v:_=>u[_]-v:h-p-v).attr("y1",c?_=>c[_]:(d+f-m)/2).attr("y2",c?_=>c[_]:(d+f-m)/2).call(un,this,i).call(e_,this,i,s)).node()}};function es(e,t){let{x:n=pe,y:i,y1:r,y2:s,...o}=i_(t);return[r,s]=XE(i,r,s),new Hd(e,{...o,x:n,y1:r,y2:s})}function Yl(e,t){let{y:n=pe,x:i,x1:r,x2:s,...o}=Vd(t);return[r,s]=XE(i,r,s),new Wd(e,{...o,y:n,x1:r,x2:s})}function XE(e,t,n){if(e==null){if(t===void 0){if(n!==void 0)return[0,n]}else if(n===void 0)return[0,t]}else{if(t===void 0)return n===void 0?[0,e]:[e,n];if(n===void 0)return[e,t]}return[t,n]}function ic(e,...t){let n=t.length;for(let i=0,r=!0;i<n;++i)typeof t[i]!="function"&&(r&&(e=e.slice(),r=!1),e.splice(i,2,e[i]+t[i]+e[i+1]),t.splice(i,1),--i,--n);return i=>{let r=e[0];for(let s=0;s<n;++s)r+=t[s](i)+e[s+1];return r}}var bB={ariaLabel:"text",strokeLinejoin:"round",strokeWidth:3,paintOrder:"stroke"},KE="­",rc=class extends ge{constructor(t,n={}){let{x:i,y:r,text:s=Vn(t)&&Md(t)?pe:hr,frameAnchor:o,textAnchor:a=/right$/i.test(o)?"end":/left$/i.test(o)?"start":"middle",lineAnchor:c=/^top/i.test(o)?"top":/^bottom/i.test(o)?"bottom":"middle",lineHeight:l=1,lineWidth:u=1/0,textOverflow:h,monospace:f,fontFamily:d=f?"ui-monospace, monospace":void 0,fontSize:p,fontStyle:y,fontVariant:m,fontWeight:g,rotate:v}=n,[S,_]=Pe(v,0),[w,b]=TB(p);if(super(t,{x:{value:i,scale:"x",optional:!0},y:{value:r,scale:"y",optional:!0},fontSize:{value:w,optional:!0},rotate:{value:qT(S),optional:!0},text:{value:s,filter:Nl,optional:!0}},n,bB),this.rotate=_,this.textAnchor=Le(a,"middle"),this.lineAnchor=In(c,"lineAnchor",["top","middle","bottom"]),this.lineHeight=+l,this.lineWidth=+u,this.textOverflow=s_(h),this.monospace=!!f,this.fontFamily=De(d),this.fontSize=b,this.fontStyle=De(y),this.fontVariant=De(m),this.fontWeight=De(g),this.frameAnchor=Ns(o),!(this.lineWidth>=0))throw new Error(`invalid lineWidth: ${u}`);this.splitLines=l_(this),this.clipLine=u_(this)}render(t,n,i,r,s){let{x:o,y:a}=n,{x:c,y:l,rotate:u,text:h,title:f,fontSize:d}=i,{rotate:p}=this,[y,m]=_r(this,r);return se("svg:g",s).call(Ue,this,r,s).call(c_,this,h,r).call(Oe,this,{x:c&&o,y:l&&a}).call(g=>g.selectAll().data(t).enter().append("text").call(Ee,this).call(MB,this,h,f).attr("transform",ic`translate(${c?v=>c[v]:y},${l?v=>l[v]:m})${u?v=>` rotate(${u[v]})`:p?` rotate(${p})`:""}`).call(Ot,"font-size",d&&(v=>d[v])).call(un,this,i)).node()}};function s_(e){return e==null?null:In(e,"textOverflow",["clip","ellipsis","clip-start","clip-end","ellipsis-start","ellipsis-middle","ellipsis-end"]).replace(/^(clip|ellipsis)$/,"$1-end")}function MB(e,t,n,i){if(!n)return;let{lineAnchor:r,lineHeight:s,textOverflow:o,splitLines:a,clipLine:c}=t;e.each(function(l){let u=a(xr(n[l])??"").map(c),h=u.length,f=r==="top"?.71:r==="bottom"?1-h:(164-h*100)/200;if(h>1){let d=0;for(let p=0;p<h;++p){if(++d,!u[p])continue;let y=this.ownerDocument.createElementNS(vs.svg,"tspan");y.setAttribute("x",0),p===d-1?y.setAttribute("y",`${(f+p)*s}em`):y.setAttribute("dy",`${d*s}em`),y.textContent=u[p],this.appendChild(y),d=0}}else f&&this.setAttribute("y",`${f*s}em`),this.textContent=u[0];if(o&&!i&&u[0]!==n[l]){let d=this.ownerDocument.createElementNS(vs.svg,"title");d.textContent=n[l],this.appendChild(d)}})}function ti(e,{x:t,y:n,...i}={}){return i.frameAnchor===void 0&&([t,n]=Bi(t,n)),new rc(e,{...i,x:t,y:n})}function o_(e,{x:t=pe,...n}={}){return new rc(e,WE({...n,x:t}))}function a_(e,{y:t=pe,...n}={}){return new rc(e,HE({...n,y:t}))}function c_(e,t,n){Ot(e,"text-anchor",t.textAnchor),Ot(e,"font-family",t.fontFamily),Ot(e,"font-size",t.fontSize),Ot(e,"font-style",t.fontStyle),Ot(e,"font-variant",t.fontVariant===void 0?SB(n):t.fontVariant),Ot(e,"font-weight",t.fontWeight)}function SB(e){return e&&(JT(e)||Ne(e))?"tabular-nums":void 0}var wB=new Set(["inherit","initial","revert","unset","xx-small","x-small","small","medium","large","x-large","xx-large","xxx-large","larger","smaller"]);function TB(e){return e==null||typeof e=="number"?[void 0,e]:typeof e!="string"?[e,void 0]:(e=e.trim().toLowerCase(),wB.has(e)||/^[+-]?\d*\.?\d+(e[+-]?\d+)?(\w*|%)$/.test(e)?[void 0,e]:[e,void 0])}function AB(e,t,n){let i=[],r,s=0;for(let[o,a,c]of EB(e)){if(r===void 0&&(r=o),s>r&&n(e,r,a)>t&&(i.push(e.slice(r,s)+(e[s-1]===KE?"-":"")),r=o),c){i.push(e.slice(r,a)),r=void 0;continue}s=a}return i}function*EB(e){let t=0,n=0,i=e.length;for(;n<i;){let r=1;switch(e[n]){case KE:case"-":++n,yield[t,n,!1],t=n;break;case" ":for(yield[t,n,!1];e[++n]===" ";);t=n;break;case"\r":e[n+1]===`
`&&++r;case`
`:yield[t,n,!0],n+=r,t=n;break;default:++n;break}}yield[t,n,!0]}var qE={a:56,b:63,c:57,d:63,e:58,f:37,g:62,h:60,i:26,j:26,k:55,l:26,m:88,n:60,o:60,p:62,q:62,r:39,s:54,t:38,u:60,v:55,w:79,x:54,y:55,z:55,A:69,B:67,C:73,D:74,E:61,F:58,G:76,H:75,I:28,J:55,K:67,L:58,M:89,N:75,O:78,P:65,Q:78,R:67,S:65,T:65,U:75,V:69,W:98,X:69,Y:67,Z:67,0:64,1:48,2:62,3:64,4:66,5:63,6:65,7:58,8:65,9:65," ":29,"!":32,'"':49,"'":31,"(":39,")":39,",":31,"-":48,".":31,"/":32,":":31,";":31,"?":52,"‘":31,"’":31,"“":47,"”":47,"…":82};function $d(e,t=0,n=e.length){let i=0;for(let r=t;r<n;r=sc(e,r))i+=qE[e[r]]??(QE(e,r)?120:qE.e);return i}function Xd(e,t=0,n=e.length){let i=0;for(let r=t;r<n;r=sc(e,r))i+=QE(e,r)?126:63;return i}function l_({monospace:e,lineWidth:t,textOverflow:n}){if(n!=null||t==1/0)return s=>s.split(/\r\n?|\n/g);let i=e?Xd:$d,r=t*100;return s=>AB(s,r,i)}function u_({monospace:e,lineWidth:t,textOverflow:n}){if(n==null||t==1/0)return s=>s;let i=e?Xd:$d,r=t*100;switch(n){case"clip-start":return s=>ZE(s,r,i,"");case"clip-end":return s=>YE(s,r,i,"");case"ellipsis-start":return s=>ZE(s,r,i,Io);case"ellipsis-middle":return s=>CB(s,r,i,Io);case"ellipsis-end":return s=>YE(s,r,i,Io)}}var Io="…";function Po(e,t,n,i){let r=[],s=0;for(let o=0,a=0,c=e.length;o<c;o=a){a=sc(e,o);let l=n(e,o,a);if(s+l>t){for(s+=i;s>t&&o>0;)a=o,o=r.pop(),s-=n(e,o,a);return[o,t-s]}s+=l,r.push(o)}return[-1,0]}function YE(e,t,n,i){e=e.trim();let r=n(i),[s]=Po(e,t,n,r);return s<0?e:e.slice(0,s).trimEnd()+i}function CB(e,t,n,i){e=e.trim();let r=n(e);if(r<=t)return e;let s=n(i)/2,[o,a]=Po(e,t/2,n,s),[c]=Po(e,r-t/2-a+s,n,-s);return c<0?i:e.slice(0,o).trimEnd()+i+e.slice(sc(e,c)).trimStart()}function ZE(e,t,n,i){e=e.trim();let r=n(e);if(r<=t)return e;let s=n(i),[o]=Po(e,r-t+s,n,-s);return o<0?i:i+e.slice(sc(e,o)).trimStart()}var r_=/[\p{Combining_Mark}\p{Emoji_Modifier}]+/uy,JE=new RegExp("\\p{Extended_Pictographic}","uy");function sc(e,t){return t+=RB(e,t)?2:1,PB(e,t)&&(t=r_.lastIndex),IB(e,t)?sc(e,t+1):t}function jE(e,t){return e.charCodeAt(t)<128}function RB(e,t){let n=e.charCodeAt(t);if(n>=55296&&n<56320){let i=e.charCodeAt(t+1);return i>=56320&&i<57344}return!1}function IB(e,t){return e.charCodeAt(t)===8205}function PB(e,t){return jE(e,t)?!1:(r_.lastIndex=t,r_.test(e))}function QE(e,t){return jE(e,t)?!1:(JE.lastIndex=t,JE.test(e))}var LB={ariaLabel:"vector",fill:"none",stroke:"currentColor",strokeWidth:1.5,strokeLinejoin:"round",strokeLinecap:"round"},t2=3.5,NB=t2*5,e2={draw(e,t,n){let i=t*n/NB;e.moveTo(0,0),e.lineTo(0,-t),e.moveTo(-i,i-t),e.lineTo(0,-t),e.lineTo(i,i-t)}},DB={draw(e,t,n){e.moveTo(-n,0),e.lineTo(0,-t),e.lineTo(n,0)}},FB=new Map([["arrow",e2],["spike",DB]]);function UB(e){return e&&typeof e.draw=="function"}function OB(e){if(UB(e))return e;let t=FB.get(`${e}`.toLowerCase());if(t)return t;throw new Error(`invalid shape: ${e}`)}var qd=class extends ge{constructor(t,n={}){let{x:i,y:r,r:s=t2,length:o,rotate:a,shape:c=e2,anchor:l="middle",frameAnchor:u}=n,[h,f]=Pe(o,12),[d,p]=Pe(a,0);super(t,{x:{value:i,scale:"x",optional:!0},y:{value:r,scale:"y",optional:!0},length:{value:h,scale:"length",optional:!0},rotate:{value:d,optional:!0}},n,LB),this.r=+s,this.length=f,this.rotate=p,this.shape=OB(c),this.anchor=In(l,"anchor",["start","middle","end"]),this.frameAnchor=Ns(u)}render(t,n,i,r,s){let{x:o,y:a}=n,{x:c,y:l,length:u,rotate:h}=i,{length:f,rotate:d,anchor:p,shape:y,r:m}=this,[g,v]=_r(this,r);return se("svg:g",s).call(Ue,this,r,s).call(Oe,this,{x:c&&o,y:l&&a}).call(S=>S.selectAll().data(t).enter().append("path").call(Ee,this).attr("transform",ic`translate(${c?_=>c[_]:g},${l?_=>l[_]:v})${h?_=>` rotate(${h[_]})`:d?` rotate(${d})`:""}${p==="start"?"":p==="end"?u?_=>` translate(0,${u[_]})`:` translate(0,${f})`:u?_=>` translate(0,${u[_]/2})`:` translate(0,${f/2})`}`).attr("d",u?_=>{let w=er();return y.draw(w,u[_],m),w}:(()=>{let _=er();return y.draw(_,f,m),_})()).call(un,this,i)).node()}};function n2(e,t={}){let{x:n=pe,...i}=t;return new qd(e,{...i,x:n})}function i2(e,t={}){let{y:n=pe,...i}=t;return new qd(e,{...i,y:n})}function Us(e,t){return arguments.length<2&&!Vn(e)&&(t=e,e=null),t===void 0&&(t={}),[e,t]}function Yd({anchor:e}={},t){return e===void 0?t[0]:In(e,"anchor",t)}function r2(e){return Yd(e,["left","right"])}function s2(e){return Yd(e,["right","left"])}function o2(e){return Yd(e,["bottom","top"])}function a2(e){return Yd(e,["top","bottom"])}function Zd(){let[e,t]=Us(...arguments);return c2("y",r2(t),e,t)}function h_(){let[e,t]=Us(...arguments);return c2("fy",s2(t),e,t)}function Jd(){let[e,t]=Us(...arguments);return l2("x",o2(t),e,t)}function d_(){let[e,t]=Us(...arguments);return l2("fx",a2(t),e,t)}function c2(e,t,n,{color:i="currentColor",opacity:r=1,stroke:s=i,strokeOpacity:o=r,strokeWidth:a=1,fill:c=i,fillOpacity:l=r,textAnchor:u,textStroke:h,textStrokeOpacity:f,textStrokeWidth:d,tickSize:p=e==="y"?6:0,tickPadding:y,tickRotate:m,x:g,margin:v,marginTop:S=v===void 0?20:v,marginRight:_=v===void 0?t==="right"?40:0:v,marginBottom:w=v===void 0?20:v,marginLeft:b=v===void 0?t==="left"?40:0:v,label:x,labelAnchor:M,labelArrow:R,labelOffset:E,ariaLabel:C=`${e}-axis`,...N}){return p=Fe(p),y=Fe(y),m=Fe(m),M!==void 0&&(M=In(M,"labelAnchor",["center","top","bottom"])),R=y2(R),$x(p&&!rn(s)?BB(e,t,n,{stroke:s,strokeOpacity:o,strokeWidth:a,tickSize:p,tickPadding:y,tickRotate:m,x:g,ariaLabel:C,...N}):null,rn(c)?null:zB(e,t,n,{fill:c,fillOpacity:l,stroke:h,strokeOpacity:f,strokeWidth:d,textAnchor:u,tickSize:p,tickPadding:y,tickRotate:m,x:g,marginTop:S,marginRight:_,marginBottom:w,marginLeft:b,ariaLabel:C,...N}),!rn(c)&&x!==null?ti([],d2({fill:c,fillOpacity:l,...N},function(B,I,L,k,F){let Z=k[e],{marginTop:U,marginRight:G,marginBottom:q,marginLeft:st}=e==="y"&&F.inset||F,ct=M??(Z.bandwidth?"center":"top"),$=E??(t==="right"?G:st)-3;return ct==="center"?(this.textAnchor=void 0,this.lineAnchor=t==="right"?"bottom":"top",this.frameAnchor=t,this.rotate=-90):(this.textAnchor=t==="right"?"end":"start",this.lineAnchor=ct,this.frameAnchor=`${ct}-${t}`,this.rotate=0),this.dy=ct==="top"?3-U:ct==="bottom"?q-3:0,this.dx=t==="right"?$:-$,this.ariaLabel=`${C} label`,{facets:[[0]],channels:{text:{value:[g2(e,Z,{anchor:t,label:x,labelAnchor:ct,labelArrow:R})]}}}})):null)}function l2(e,t,n,{color:i="currentColor",opacity:r=1,stroke:s=i,strokeOpacity:o=r,strokeWidth:a=1,fill:c=i,fillOpacity:l=r,textAnchor:u,textStroke:h,textStrokeOpacity:f,textStrokeWidth:d,tickSize:p=e==="x"?6:0,tickPadding:y,tickRotate:m,y:g,margin:v,marginTop:S=v===void 0?t==="top"?30:0:v,marginRight:_=v===void 0?20:v,marginBottom:w=v===void 0?t==="bottom"?30:0:v,marginLeft:b=v===void 0?20:v,label:x,labelAnchor:M,labelArrow:R,labelOffset:E,ariaLabel:C=`${e}-axis`,...N}){return p=Fe(p),y=Fe(y),m=Fe(m),M!==void 0&&(M=In(M,"labelAnchor",["center","left","right"])),R=y2(R),$x(p&&!rn(s)?kB(e,t,n,{stroke:s,strokeOpacity:o,strokeWidth:a,tickSize:p,tickPadding:y,tickRotate:m,y:g,ariaLabel:C,...N}):null,rn(c)?null:GB(e,t,n,{fill:c,fillOpacity:l,stroke:h,strokeOpacity:f,strokeWidth:d,textAnchor:u,tickSize:p,tickPadding:y,tickRotate:m,y:g,marginTop:S,marginRight:_,marginBottom:w,marginLeft:b,ariaLabel:C,...N}),!rn(c)&&x!==null?ti([],d2({fill:c,fillOpacity:l,...N},function(B,I,L,k,F){let Z=k[e],{marginTop:U,marginRight:G,marginBottom:q,marginLeft:st}=e==="x"&&F.inset||F,ct=M??(Z.bandwidth?"center":"right"),$=E??(t==="top"?U:q)-3;return ct==="center"?(this.frameAnchor=t,this.textAnchor=void 0):(this.frameAnchor=`${t}-${ct}`,this.textAnchor=ct==="right"?"end":"start"),this.lineAnchor=t,this.dy=t==="top"?-$:$,this.dx=ct==="right"?G-3:ct==="left"?3-st:0,this.ariaLabel=`${C} label`,{facets:[[0]],channels:{text:{value:[g2(e,Z,{anchor:t,label:x,labelAnchor:ct,labelArrow:R})]}}}})):null)}function BB(e,t,n,{strokeWidth:i=1,strokeLinecap:r=null,strokeLinejoin:s=null,facetAnchor:o=t+(e==="y"?"-empty":""),frameAnchor:a=t,tickSize:c,inset:l=0,insetLeft:u=l,insetRight:h=l,dx:f=0,y:d=e==="y"?void 0:null,ariaLabel:p,...y}){return oc(i2,e,n,{ariaLabel:`${p} tick`,ariaHidden:!0},{strokeWidth:i,strokeLinecap:r,strokeLinejoin:s,facetAnchor:o,frameAnchor:a,y:d,...y,dx:t==="left"?+f-ln+ +u:+f+ln-h,anchor:"start",length:c,shape:t==="left"?$B:XB})}function kB(e,t,n,{strokeWidth:i=1,strokeLinecap:r=null,strokeLinejoin:s=null,facetAnchor:o=t+(e==="x"?"-empty":""),frameAnchor:a=t,tickSize:c,inset:l=0,insetTop:u=l,insetBottom:h=l,dy:f=0,x:d=e==="x"?void 0:null,ariaLabel:p,...y}){return oc(n2,e,n,{ariaLabel:`${p} tick`,ariaHidden:!0},{strokeWidth:i,strokeLinejoin:s,strokeLinecap:r,facetAnchor:o,frameAnchor:a,x:d,...y,dy:t==="bottom"?+f-ln-h:+f+ln+ +u,anchor:"start",length:c,shape:t==="bottom"?HB:WB})}function zB(e,t,n,{facetAnchor:i=t+(e==="y"?"-empty":""),frameAnchor:r=t,tickSize:s,tickRotate:o=0,tickPadding:a=Math.max(3,9-s)+(Math.abs(o)>60?4*Math.cos(o*Kx):0),text:c,textAnchor:l=Math.abs(o)>60?"middle":t==="left"?"end":"start",lineAnchor:u=o>60?"top":o<-60?"bottom":"middle",fontVariant:h,inset:f=0,insetLeft:d=f,insetRight:p=f,dx:y=0,ariaLabel:m,y:g=e==="y"?void 0:null,...v}){return oc(a_,e,n,{ariaLabel:`${m} tick label`},{facetAnchor:i,frameAnchor:r,text:c,textAnchor:l,lineAnchor:u,fontVariant:h,rotate:o,y:g,...v,dx:t==="left"?+y-s-a+ +d:+y+ +s+ +a-p},function(S,_,w,b,x){h===void 0&&(this.fontVariant=m2(S)),c===void 0&&(x.text=p2(S,_,w,b,t))})}function GB(e,t,n,{facetAnchor:i=t+(e==="x"?"-empty":""),frameAnchor:r=t,tickSize:s,tickRotate:o=0,tickPadding:a=Math.max(3,9-s)+(Math.abs(o)>=10?4*Math.cos(o*Kx):0),text:c,textAnchor:l=Math.abs(o)>=10?o<0^t==="bottom"?"start":"end":"middle",lineAnchor:u=Math.abs(o)>=10?"middle":t==="bottom"?"top":"bottom",fontVariant:h,inset:f=0,insetTop:d=f,insetBottom:p=f,dy:y=0,x:m=e==="x"?void 0:null,ariaLabel:g,...v}){return oc(o_,e,n,{ariaLabel:`${g} tick label`},{facetAnchor:i,frameAnchor:r,text:c===void 0?null:c,textAnchor:l,lineAnchor:u,fontVariant:h,rotate:o,x:m,...v,dy:t==="bottom"?+y+ +s+ +a-p:+y-s-a+ +d},function(S,_,w,b,x){h===void 0&&(this.fontVariant=m2(S)),c===void 0&&(x.text=p2(S,_,w,b,t))})}function Lo(){let[e,t]=Us(...arguments);return u2("y",r2(t),e,t)}function p_(){let[e,t]=Us(...arguments);return u2("fy",s2(t),e,t)}function Zl(){let[e,t]=Us(...arguments);return f2("x",o2(t),e,t)}function m_(){let[e,t]=Us(...arguments);return f2("fx",a2(t),e,t)}function u2(e,t,n,{y:i=e==="y"?void 0:null,x:r=null,x1:s=t==="left"?r:null,x2:o=t==="right"?r:null,ariaLabel:a=`${e}-grid`,ariaHidden:c=!0,...l}){return oc(Yl,e,n,{ariaLabel:a,ariaHidden:c},{y:i,x1:s,x2:o,...h2(l)})}function f2(e,t,n,{x:i=e==="x"?void 0:null,y:r=null,y1:s=t==="top"?r:null,y2:o=t==="bottom"?r:null,ariaLabel:a=`${e}-grid`,ariaHidden:c=!0,...l}){return oc(es,e,n,{ariaLabel:a,ariaHidden:c},{x:i,y1:s,y2:o,...h2(l)})}function h2({color:e="currentColor",opacity:t=.1,stroke:n=e,strokeOpacity:i=t,strokeWidth:r=1,...s}){return{stroke:n,strokeOpacity:i,strokeWidth:r,...s}}function d2({fill:e,fillOpacity:t,fontFamily:n,fontSize:i,fontStyle:r,fontVariant:s,fontWeight:o,monospace:a,pointerEvents:c,shapeRendering:l,clip:u=!1},h){return[,e]=Gn(e),[,t]=Pe(t),{facet:"super",x:null,y:null,fill:e,fillOpacity:t,fontFamily:n,fontSize:i,fontStyle:r,fontVariant:s,fontWeight:o,monospace:a,pointerEvents:c,shapeRendering:l,clip:u,initializer:h}}function oc(e,t,n,i,r,s){let o;function a(u,h,f,d,p,y){let m=u==null&&(t==="fx"||t==="fy"),{[t]:g}=d;if(!g)throw new Error(`missing scale: ${t}`);let v=g.domain(),{interval:S,ticks:_,tickFormat:w,tickSpacing:b=t==="x"?80:35}=r;if(typeof _=="string"&&x2(g)&&(S=_,_=void 0),_===void 0&&(_=mr(S,g.type)??VB(g,b)),u==null){if(Vn(_))u=pr(_);else if(Ls(_))u=f_(_,...cn(v));else if(g.interval){let M=g.interval;if(g.ticks){let[R,E]=cn(v),C=(E-R)/M[Oa];M=jy(M,C/_)??M,u=f_(M,R,E)}else{u=v;let R=u.length;M=jy(M,R/_)??M,M!==g.interval&&(u=f_(M,...cn(u)))}if(M===g.interval){let R=Math.round(u.length/_);R>1&&(u=u.filter((E,C)=>C%R===0))}}else g.ticks?u=g.ticks(_):u=v;if(!g.ticks&&u.length&&u!==v){let M=new ji(v);u=u.filter(R=>M.has(R)),u.length||Hn(`Warning: the ${t}-axis ticks appear to not align with the scale domain, resulting in no ticks. Try different ticks?`)}t==="y"||t==="x"?h=[Pn(u)]:o[t]={scale:t,value:pe}}s?.call(this,g,u,_,w,o);let x=Object.fromEntries(Object.entries(o).map(([M,R])=>[M,{...R,value:Se(u,R.value)}]));return m&&(h=y.filterFacets(u,x)),{data:u,facets:h,channels:x}}let c=Jr(r).initializer,l=e(n,Jr({...r,initializer:a},c));return n==null?(o=l.channels,l.channels={}):o={},i!==void 0&&Object.assign(l,i),l.clip===void 0&&(l.clip=!1),l}function VB(e,t){let[n,i]=cn(e.range());return(i-n)/t}function p2(e,t,n,i,r){return{value:Jl(e,t,n,i,r)}}function Jl(e,t,n,i,r){return typeof i=="function"&&!(e.type==="log"&&e.tickFormat)?i:i===void 0&&t&&Ne(t)?DT(e.type,t,r)??xr:e.tickFormat?e.tickFormat(typeof n=="number"?n:null,i):typeof i=="string"&&e.domain().length>0?(Ne(e.domain())?cr:nr)(i):i===void 0?xr:jn(i)}function f_(e,t,n){return e.range(t,e.offset(e.floor(n)))}var HB={draw(e,t){e.moveTo(0,0),e.lineTo(0,t)}},WB={draw(e,t){e.moveTo(0,0),e.lineTo(0,-t)}},$B={draw(e,t){e.moveTo(0,0),e.lineTo(-t,0)}},XB={draw(e,t){e.moveTo(0,0),e.lineTo(t,0)}};function m2(e){return e.bandwidth&&!e.interval?void 0:"tabular-nums"}function g2(e,t,{anchor:n,label:i=t.label,labelAnchor:r,labelArrow:s}={}){if(!(i==null||i.inferred&&x2(t)&&/^(date|time|year)$/i.test(i))){if(i=String(i),s==="auto"&&(s=(!t.bandwidth||t.interval)&&!/[↑↓→←]/.test(i)),!s)return i;if(s===!0){let o=oE(t);o&&(s=/x$/.test(e)||r==="center"?/x$/.test(e)===o<0?"left":"right":o<0?"up":"down")}switch(s){case"left":return`← ${i}`;case"right":return`${i} →`;case"up":return n==="right"?`${i} ↑`:`↑ ${i}`;case"down":return n==="right"?`${i} ↓`:`↓ ${i}`}return i}}function y2(e="auto"){return rn(e)?!1:typeof e=="boolean"?e:In(e,"labelArrow",["auto","up","right","down","left"])}function x2(e){return Ne(e.domain())}function _2(e,t){if(t==null)return t;let n=e(t);if(!n)throw new Error(`scale not found: ${t}`);return n}function v2(e,{opacity:t,...n}={}){if(!yr(e)&&!Ox(e))throw new Error(`swatches legend requires ordinal or threshold color scale (not ${e.type})`);return M2(e,n,(i,r,s,o)=>i.append("svg").attr("width",s).attr("height",o).attr("fill",r.scale).attr("fill-opacity",Pe(t)[1]).append("rect").attr("width","100%").attr("height","100%"))}function b2(e,{fill:t=e.hint?.fill!==void 0?e.hint.fill:"none",fillOpacity:n=1,stroke:i=e.hint?.stroke!==void 0?e.hint.stroke:rn(t)?"currentColor":"none",strokeOpacity:r=1,strokeWidth:s=1.5,r:o=4.5,...a}={},c){let[l,u]=Gn(t),[h,f]=Gn(i),d=_2(c,l),p=_2(c,h),y=o*o*Math.PI;return n=Pe(n)[1],r=Pe(r)[1],s=Pe(s)[1],M2(e,a,(m,g,v,S)=>m.append("svg").attr("viewBox","-8 -8 16 16").attr("width",v).attr("height",S).attr("fill",l==="color"?_=>d.scale(_):u).attr("fill-opacity",n).attr("stroke",h==="color"?_=>p.scale(_):f).attr("stroke-opacity",r).attr("stroke-width",s).append("path").attr("d",_=>{let w=er();return e.scale(_).draw(w,y),w}))}function M2(e,t={},n){let{columns:i,tickFormat:r,fontVariant:s=zd(e),swatchSize:o=15,swatchWidth:a=o,swatchHeight:c=o,marginLeft:l=0,className:u,style:h,width:f}=t,d=Qa(t);u=tc(u),r=Jl(e.scale,e.domain,void 0,r);let p=se("div",d).attr("class",`${u}-swatches ${u}-swatches-${i!=null?"columns":"wrap"}`),y;return i!=null?(y=`:where(.${u}-swatches-columns .${u}-swatch) {
  display: flex;
  align-items: center;
  break-inside: avoid;
  padding-bottom: 1px;
}
:where(.${u}-swatches-columns .${u}-swatch::before) {
  flex-shrink: 0;
}
:where(.${u}-swatches-columns .${u}-swatch-label) {
  white-space: nowrap;
  overflow: hidden;
  text-overflow: ellipsis;
}`,p.style("columns",i).selectAll().data(e.domain).enter().append("div").attr("class",`${u}-swatch`).call(n,e,a,c).call(m=>m.append("div").attr("class",`${u}-swatch-label`).attr("title",r).text(r))):(y=`:where(.${u}-swatches-wrap) {
  display: flex;
  align-items: center;
  min-height: 33px;
  flex-wrap: wrap;
}
:where(.${u}-swatches-wrap .${u}-swatch) {
  display: inline-flex;
  align-items: center;
  margin-right: 1em;
}`,p.selectAll().data(e.domain).enter().append("span").attr("class",`${u}-swatch`).call(n,e,a,c).append(function(){return this.ownerDocument.createTextNode(r.apply(this,arguments))})),p.call(m=>m.insert("style","*").text(`:where(.${u}-swatches) {
  font-family: system-ui, sans-serif;
  font-size: 10px;
  margin-bottom: 0.5em;
}
:where(.${u}-swatch > svg) {
  margin-right: 0.5em;
  overflow: visible;
}
${y}`)).style("margin-left",l?`${+l}px`:null).style("width",f===void 0?null:`${+f}px`).style("font-variant",Le(s,"normal")).call(ec,h).node()}var g_=new Map([["symbol",b2],["color",T2],["opacity",qB]]);function S2(e,t,n={}){return(i,r)=>{if(!g_.has(i))throw new Error(`unknown legend type: ${i}`);if(i in e)return g_.get(i)(e[i],w2(t,n[i],r),s=>e[s])}}function w2({className:e,...t},{label:n,ticks:i,tickFormat:r}={},s){return QT(s,{className:e,...t},{label:n,ticks:i,tickFormat:r})}function T2(e,{legend:t=!0,...n}){if(t===!0&&(t=e.type==="ordinal"?"swatches":"ramp"),e.domain!==void 0)switch(`${t}`.toLowerCase()){case"swatches":return v2(e,n);case"ramp":return NE(e,n);default:throw new Error(`unknown legend type: ${t}`)}}function qB({type:e,interpolate:t,...n},{legend:i=!0,color:r=Fi(0,0,0),...s}){if(!t)throw new Error(`${e} opacity scales are not supported`);if(i===!0&&(i="ramp"),`${i}`.toLowerCase()!=="ramp")throw new Error(`${i} opacity legends are not supported`);return T2({type:e,...n,interpolate:YB(r)},{legend:i,...s})}function YB(e){let{r:t,g:n,b:i}=Fi(e)||Fi(0,0,0);return r=>`rgba(${t},${n},${i},${r})`}function A2(e,t,n){let i=[];for(let[r,s]of g_){let o=n[r];if(o?.legend&&r in e){let a=s(e[r],w2(t,e[r],o),c=>e[c]);a!=null&&i.push(a)}}return i}function Kl(e={},t="x"){return cx(e)?e:{...e,[t]:pe}}function Kd(e={},t="y"){return lx(e)?e:{...e,[t]:pe}}function E2(e,t){if(t.length===1)return{data:e,facets:t};let n=Ps(e),i=new Uint8Array(n),r=0;for(let a of t)for(let c of a)i[c]&&++r,i[c]=1;if(r===0)return{data:e,facets:t};e=Rs(e);let s=e[ex]=new Uint32Array(n+r);t=t.map(a=>Rs(a,Uint32Array));let o=n;i.fill(0);for(let a of t)for(let c=0,l=a.length;c<l;++c){let u=a[c];i[u]?(a[c]=o,e[o]=e[u],s[o]=u,++o):s[u]=u,i[u]=1}return{data:e,facets:t}}function ZB(e={},t={}){arguments.length===1&&([e,t]=I2(e));let{y1:n,y:i=n,x:r,...s}=t,[o,a,c,l]=P2(i,r,"y","x",e,s);return{...o,y1:n,y:a,x1:c,x2:l,x:Ha(c,l)}}function JB(e={},t={}){arguments.length===1&&([e,t]=I2(e));let{x1:n,x:i=n,y:r,...s}=t,[o,a,c,l]=P2(i,r,"x","y",e,s);return{...o,x1:n,x:a,y1:c,y2:l,y:Ha(c,l)}}function jl({x:e,x1:t,x2:n,...i}={}){return i=Fs(i,"y"),t===void 0&&n===void 0?ZB({x:e,...i}):([t,n]=ux(e,t,n),{...i,x1:t,x2:n})}function jd({y:e,y1:t,y2:n,...i}={}){return i=Fs(i,"x"),t===void 0&&n===void 0?JB({y:e,...i}):([t,n]=ux(e,t,n),{...i,y1:t,y2:n})}function I2(e){let{offset:t,order:n,reverse:i,...r}=e;return[{offset:t,order:n,reverse:i},r]}var KB={length:!0};function P2(e,t=kT,n,i,{offset:r,order:s,reverse:o},a){if(t===null)throw new Error(`stack requires ${i}`);let c=Ga(a),[l,u]=vi(e),[h,f]=Va(t),[d,p]=Va(t);return h.hint=d.hint=KB,r=jB(r),s=e6(s,r,i),[Ro(a,(y,m,g)=>{({data:y,facets:m}=E2(y,m));let v=e==null?void 0:u(Bl(Se(y,e),g?.[n])),S=Se(y,t,Float64Array),_=Se(y,c),w=s&&s(y,v,S,_),b=Ps(y),x=f(new Float64Array(b)),M=p(new Float64Array(b)),R=[];for(let E of m){let C=v?Array.from(to(E,N=>v[N]).values()):[E];if(w)for(let N of C)N.sort(w);for(let N of C){let B=0,I=0;o&&N.reverse();for(let L of N){let k=S[L];k<0?B=M[L]=(x[L]=B)+k:k>0?I=M[L]=(x[L]=I)+k:M[L]=x[L]=I}}R.push(C)}return r&&r(R,x,M,_),{data:y,facets:m}}),l,h,d]}function jB(e){if(e!=null){if(typeof e=="function")return e;switch(`${e}`.toLowerCase()){case"expand":case"normalize":return QB;case"center":case"silhouette":return t6;case"wiggle":return N2}throw new Error(`unknown offset: ${e}`)}}function L2(e,t){let n=0,i=0;for(let r of e){let s=t[r];s<n&&(n=s),s>i&&(i=s)}return[n,i]}function QB(e,t,n){for(let i of e)for(let r of i){let[s,o]=L2(r,n);for(let a of r){let c=1/(o-s||1);t[a]=c*(t[a]-s),n[a]=c*(n[a]-s)}}}function t6(e,t,n){for(let i of e){for(let r of i){let[s,o]=L2(r,n);for(let a of r){let c=(o+s)/2;t[a]-=c,n[a]-=c}}D2(i,t,n)}F2(e,t,n)}function N2(e,t,n,i){for(let r of e){let s=new ai,o=0;for(let a of r){let c=-1,l=a.map(d=>Math.abs(n[d]-t[d])),u=a.map(d=>{c=i?i[d]:++c;let p=n[d]-t[d],y=s.has(c)?p-s.get(c):0;return s.set(c,p),y}),h=[0,...g1(u)];for(let d of a)t[d]+=o,n[d]+=o;let f=Li(l);f&&(o-=Li(l,(d,p)=>(u[p]/2+h[p])*d)/f)}D2(r,t,n)}F2(e,t,n)}function D2(e,t,n){let i=ci(e,r=>ci(r,s=>t[s]));for(let r of e)for(let s of r)t[s]-=i,n[s]-=i}function F2(e,t,n){let i=e.length;if(i===1)return;let r=e.map(a=>a.flat()),s=r.map(a=>(ci(a,c=>t[c])+An(a,c=>n[c]))/2),o=ci(s);for(let a=0;a<i;a++){let c=o-s[a];for(let l of r[a])t[l]+=c,n[l]+=c}}function e6(e,t,n){if(e===void 0&&t===N2)return C2(yn);if(e!=null){if(typeof e=="string"){let i=e.startsWith("-"),r=i?Mo:yn;switch((i?e.slice(1):e).toLowerCase()){case"value":case n:return n6(r);case"z":return i6(r);case"sum":return r6(r);case"appearance":return s6(r);case"inside-out":return C2(r)}return R2(ix(e))}if(typeof e=="function")return(e.length===1?R2:o6)(e);if(Ui(e))return a6(e);throw new Error(`invalid order: ${e}`)}}function n6(e){return(t,n,i)=>(r,s)=>e(i[r],i[s])}function i6(e){return(t,n,i,r)=>(s,o)=>e(r[s],r[o])}function r6(e){return Qd(e,(t,n,i,r)=>fh(Pn(t),s=>Li(s,o=>i[o]),s=>r[s]))}function s6(e){return Qd(e,(t,n,i,r)=>fh(Pn(t),s=>n[Jm(s,o=>i[o])],s=>r[s]))}function C2(e){return Qd(e,(t,n,i,r)=>{let s=Pn(t),o=fh(s,h=>n[Jm(h,f=>i[f])],h=>r[h]),a=Br(s,h=>Li(h,f=>i[f]),h=>r[h]),c=[],l=[],u=0;for(let h of o)u<0?(u+=a.get(h),c.push(h)):(u-=a.get(h),l.push(h));return l.reverse().concat(c)})}function R2(e){return t=>{let n=Se(t,e);return(i,r)=>yn(n[i],n[r])}}function o6(e){return t=>Ui(t)?(n,i)=>e(t[n],t[i]):(n,i)=>e(t.get(n),t.get(i))}function a6(e){return Qd(yn,()=>e)}function Qd(e,t){return(n,i,r,s)=>{if(!s)throw new Error("missing channel: z");let o=new ai(t(n,i,r,s).map((a,c)=>[a,c]));return(a,c)=>e(o.get(s[a]),o.get(s[c]))}}var c6={ariaLabel:"rect"},Ql=class extends ge{constructor(t,n={}){let{x1:i,y1:r,x2:s,y2:o}=n;super(t,{x1:{value:i,scale:"x",type:i!=null&&s==null?"band":void 0,optional:!0},y1:{value:r,scale:"y",type:r!=null&&o==null?"band":void 0,optional:!0},x2:{value:s,scale:"x",optional:!0},y2:{value:o,scale:"y",optional:!0}},n,c6),tu(this,n),eu(this,n)}render(t,n,i,r,s){let{x:o,y:a}=n,{x1:c,y1:l,x2:u,y2:h}=i,{marginTop:f,marginRight:d,marginBottom:p,marginLeft:y,width:m,height:g}=r,{projection:v}=s,{insetTop:S,insetRight:_,insetBottom:w,insetLeft:b}=this,{rx:x,ry:M,rx1y1:R,rx1y2:E,rx2y1:C,rx2y2:N}=this;(c||u)&&!v&&zi(o)&&(c=u=null),(l||h)&&!v&&zi(a)&&(l=h=null);let B=o?.bandwidth?o.bandwidth():0,I=a?.bandwidth?a.bandwidth():0;return se("svg:g",s).call(Ue,this,r,s).call(Oe,this,{},0,0).call(L=>L.selectAll().data(t).enter().call(R||E||C||N?k=>k.append("path").call(Ee,this).call(nu,c&&u?F=>c[F]+(u[F]<c[F]?-_:b):c?F=>c[F]+b:y+b,l&&h?F=>l[F]+(h[F]<l[F]?-w:S):l?F=>l[F]+S:f+S,c&&u?F=>u[F]-(u[F]<c[F]?-b:_):c?F=>c[F]+B-_:m-d-_,l&&h?F=>h[F]-(h[F]<l[F]?-S:w):l?F=>l[F]+I-w:g-p-w,this).call(un,this,i):k=>k.append("rect").call(Ee,this).attr("x",c?u?F=>Math.min(c[F],u[F])+b:F=>c[F]+b:y+b).attr("y",l?h?F=>Math.min(l[F],h[F])+S:F=>l[F]+S:f+S).attr("width",c?u?F=>Math.max(0,Math.abs(u[F]-c[F])+B-b-_):B-b-_:m-d-y-_-b).attr("height",l?h?F=>Math.max(0,Math.abs(l[F]-h[F])+I-S-w):I-S-w:g-f-p-S-w).call(Ot,"rx",x).call(Ot,"ry",M).call(un,this,i))).node()}};function tu(e,{inset:t=0,insetTop:n=t,insetRight:i=t,insetBottom:r=t,insetLeft:s=t}={}){e.insetTop=Fe(n),e.insetRight=Fe(i),e.insetBottom=Fe(r),e.insetLeft=Fe(s)}function eu(e,{r:t,rx:n,ry:i,rx1:r=t,ry1:s=t,rx2:o=t,ry2:a=t,rx1y1:c=r!==void 0?+r:s!==void 0?+s:0,rx1y2:l=r!==void 0?+r:a!==void 0?+a:0,rx2y1:u=o!==void 0?+o:s!==void 0?+s:0,rx2y2:h=o!==void 0?+o:a!==void 0?+a:0}={}){c||l||u||h?(e.rx1y1=c,e.rx1y2=l,e.rx2y1=u,e.rx2y2=h):(e.rx=Le(n,"auto"),e.ry=Le(i,"auto"))}function nu(e,t,n,i,r,s){let{rx1y1:o,rx1y2:a,rx2y1:c,rx2y2:l}=s;typeof t!="function"&&(t=jn(t)),typeof n!="function"&&(n=jn(n)),typeof i!="function"&&(i=jn(i)),typeof r!="function"&&(r=jn(r));let u=Math.max(Math.abs(o+c),Math.abs(a+l)),h=Math.max(Math.abs(o+a),Math.abs(c+l));e.attr("d",f=>{let d=t(f),p=n(f),y=i(f),m=r(f),g=d>y,v=p>m,S=g?y:d,_=g?d:y,w=v?m:p,b=v?p:m,x=Math.min(1,(_-S)/u,(b-w)/h),M=x*(g?v?l:c:v?a:o),R=x*(g?v?a:o:v?l:c),E=x*(g?v?o:a:v?c:l),C=x*(g?v?c:l:v?o:a);return`M${S},${w+ep(M,C)}A${M},${M} 0 0 ${M<0?0:1} ${S+tp(M,C)},${w}H${_-tp(R,E)}A${R},${R} 0 0 ${R<0?0:1} ${_},${w+ep(R,E)}V${b-ep(E,R)}A${E},${E} 0 0 ${E<0?0:1} ${_-tp(E,R)},${b}H${S+tp(C,M)}A${C},${C} 0 0 ${C<0?0:1} ${S},${b-ep(C,M)}Z`})}function tp(e,t){return t<0?e:Math.abs(e)}function ep(e,t){return t<0?Math.abs(e):e}function y_(e,t){return new Ql(e,VE(n_(t)))}function x_(e,t={}){return _d(t)||(t={...t,y:hr,x2:pe,interval:1}),new Ql(e,jl(n_(Kl(t))))}var l6={ariaLabel:"frame",fill:"none",stroke:"currentColor",clip:!1},u6={ariaLabel:"frame",fill:null,stroke:"currentColor",strokeLinecap:"square",clip:!1},__=class extends ge{constructor(t={}){let{anchor:n=null}=t;super(Ba,void 0,t,n==null?l6:u6),this.anchor=ax(n,"anchor",["top","right","bottom","left"]),tu(this,t),n||eu(this,t)}render(t,n,i,r,s){let{marginTop:o,marginRight:a,marginBottom:c,marginLeft:l,width:u,height:h}=r,{anchor:f,insetTop:d,insetRight:p,insetBottom:y,insetLeft:m}=this,{rx:g,ry:v,rx1y1:S,rx1y2:_,rx2y1:w,rx2y2:b}=this,x=l+m,M=u-a-p,R=o+d,E=h-c-y;return se(f?"svg:line":S||_||w||b?"svg:path":"svg:rect",s).datum(0).call(Ue,this,r,s).call(Ee,this).call(un,this,i).call(Oe,this,{}).call(f==="left"?C=>C.attr("x1",x).attr("x2",x).attr("y1",R).attr("y2",E):f==="right"?C=>C.attr("x1",M).attr("x2",M).attr("y1",R).attr("y2",E):f==="top"?C=>C.attr("x1",x).attr("x2",M).attr("y1",R).attr("y2",R):f==="bottom"?C=>C.attr("x1",x).attr("x2",M).attr("y1",E).attr("y2",E):S||_||w||b?C=>C.call(nu,x,R,M,E,this):C=>C.attr("x",x).attr("y",R).attr("width",M-x).attr("height",E-R).attr("rx",g).attr("ry",v)).node()}};function U2(e){return new __(e)}var v_={ariaLabel:"tip",fill:"var(--plot-background)",stroke:"currentColor"},f6=new Set(["geometry","href","src","ariaLabel","scales"]),b_=class extends ge{constructor(t,n={}){n.tip&&(n={...n,tip:!1}),n.title===void 0&&Vn(t)&&Md(t)&&(n={...n,title:pe});let{x:i,y:r,x1:s,x2:o,y1:a,y2:c,anchor:l,preferredAnchor:u="bottom",monospace:h,fontFamily:f=h?"ui-monospace, monospace":void 0,fontSize:d,fontStyle:p,fontVariant:y,fontWeight:m,lineHeight:g=1,lineWidth:v=20,frameAnchor:S,format:_,textAnchor:w="start",textOverflow:b,textPadding:x=8,title:M,pointerSize:R=12,pathFilter:E="drop-shadow(0 3px 4px rgba(0,0,0,0.2))"}=n;super(t,{x:{value:s!=null&&o!=null?null:i,scale:"x",optional:!0},y:{value:a!=null&&c!=null?null:r,scale:"y",optional:!0},x1:{value:s,scale:"x",optional:o==null},y1:{value:a,scale:"y",optional:c==null},x2:{value:o,scale:"x",optional:s==null},y2:{value:c,scale:"y",optional:a==null},title:{value:M,optional:!0}},n,v_),this.anchor=wd(l,"anchor"),this.preferredAnchor=wd(u,"preferredAnchor"),this.frameAnchor=Ns(S),this.textAnchor=Le(w,"middle"),this.textPadding=+x,this.pointerSize=+R,this.pathFilter=De(E),this.lineHeight=+g,this.lineWidth=+v,this.textOverflow=s_(b),this.monospace=!!h,this.fontFamily=De(f),this.fontSize=Fe(d),this.fontStyle=De(p),this.fontVariant=De(y),this.fontWeight=De(m);for(let C in v_)C in this.channels&&(this[C]=v_[C]);this.splitLines=l_(this),this.clipLine=u_(this),this.format=typeof _=="string"||typeof _=="function"?{title:_}:{..._}}render(t,n,i,r,s){let o=this,{x:a,y:c,fx:l,fy:u}=n,{ownerSVGElement:h,document:f}=s,{anchor:d,monospace:p,lineHeight:y,lineWidth:m}=this,{textPadding:g,pointerSize:v,pathFilter:S}=this,{marginTop:_,marginLeft:w}=r,{x1:b,y1:x,x2:M,y2:R,x:E=b??M,y:C=x??R}=i,N=l?l(t.fx)-w:0,B=u?u(t.fy)-_:0,[I,L]=_r(this,r),k=Zx(i,I),F=Jx(i,L),Z=p?Xd:$d,U=Z(Io),G,q;"title"in i?(G=O2.call(this,{title:i.channels.title},n),q=m6):(G=O2.call(this,i.channels,n),q=g6);let st=se("svg:g",s).call(Ue,this,r,s).call(c_,this).call(Oe,this,{x:E&&a,y:C&&c}).call(at=>at.selectAll().data(t).enter().append("g").attr("transform",ft=>`translate(${Math.round(k(ft))},${Math.round(F(ft))})`).call(Ee,this).call(ft=>ft.append("path").attr("filter",S)).call(ft=>ft.append("text").each(function(ot){let rt=Ni(this);this.setAttribute("fill","currentColor"),this.setAttribute("fill-opacity",1),this.setAttribute("stroke","none");let J=q.call(o,ot,t,G,n,i);if(typeof J=="string")for(let gt of o.splitLines(J))ct(rt,{value:o.clipLine(gt)});else{let gt=new Set;for(let lt of J){let{label:K=""}=lt;K&&gt.has(K)||(gt.add(K),ct(rt,lt))}}})));function ct(at,{label:ft,value:ot,color:rt,opacity:J}){ft??="",ot??="";let gt=rt!=null||J!=null,lt,K=m*100,[It]=Po(ft,K,Z,U);if(It>=0)ft=ft.slice(0,It).trimEnd()+Io,lt=ot.trim(),ot="";else{(ft||!ot&&!gt)&&(ot=" "+ot);let[Ut]=Po(ot,K-Z(ft),Z,U);Ut>=0&&(lt=ot.trim(),ot=ot.slice(0,Ut).trimEnd()+Io)}let pt=at.append("tspan").attr("x",0).attr("dy",`${y}em`).text("​");ft&&pt.append("tspan").attr("font-weight","bold").text(ft),ot&&pt.append(()=>f.createTextNode(ot)),gt&&pt.append("tspan").text(" ■").attr("fill",rt).attr("fill-opacity",J).style("user-select","none"),lt&&pt.append("title").text(lt)}function $(){let{width:at,height:ft}=r.facet??r;st.selectChildren().each(function(ot){let{x:rt,width:J,height:gt}=this.getBBox();J=Math.round(J),gt=Math.round(gt);let lt=d;if(lt===void 0){let pt=k(ot)+N,Ut=F(ot)+B,Gt=pt+J+v+g*2<at,ce=pt-J-v-g*2>0,oe=Ut+gt+v+g*2<ft,Xe=Ut-gt-v-g*2>0;lt=Gt&&ce?oe&&Xe?o.preferredAnchor:Xe?"bottom":"top":oe&&Xe?Gt?"left":"right":(Gt||ce)&&(oe||Xe)?`${Xe?"bottom":"top"}-${Gt?"left":"right"}`:o.preferredAnchor}let K=this.firstChild,It=this.lastChild;if(K.setAttribute("d",p6(lt,v,g,J,gt)),rt)for(let pt of It.childNodes)pt.setAttribute("x",-rt);It.setAttribute("y",`${+h6(lt,It.childNodes.length,y).toFixed(6)}em`),It.setAttribute("transform",`translate(${d6(lt,v,g,J,gt)})`)}),st.attr("visibility",null)}return t.length&&(st.attr("visibility","hidden"),h.isConnected?Promise.resolve().then($):typeof requestAnimationFrame<"u"&&requestAnimationFrame($)),st.node()}};function G2(e,{x:t,y:n,...i}={}){return i.frameAnchor===void 0&&([t,n]=Bi(t,n)),new b_(e,{...i,x:t,y:n})}function h6(e,t,n){return/^top(?:-|$)/.test(e)?.94-n:-.29-t*n}function d6(e,t,n,i,r){switch(e){case"middle":return[-i/2,r/2];case"top-left":return[n,t+n];case"top":return[-i/2,t/2+n];case"top-right":return[-i-n,t+n];case"right":return[-t/2-i-n,r/2];case"bottom-left":return[n,-t-n];case"bottom":return[-i/2,-t/2-n];case"bottom-right":return[-i-n,-t-n];case"left":return[n+t/2,r/2]}}function p6(e,t,n,i,r){let s=i+n*2,o=r+n*2;switch(e){case"middle":return`M${-s/2},${-o/2}h${s}v${o}h${-s}z`;case"top-left":return`M0,0l${t},${t}h${s-t}v${o}h${-s}z`;case"top":return`M0,0l${t/2},${t/2}h${(s-t)/2}v${o}h${-s}v${-o}h${(s-t)/2}z`;case"top-right":return`M0,0l${-t},${t}h${t-s}v${o}h${s}z`;case"right":return`M0,0l${-t/2},${-t/2}v${t/2-o/2}h${-s}v${o}h${s}v${t/2-o/2}z`;case"bottom-left":return`M0,0l${t},${-t}h${s-t}v${-o}h${-s}z`;case"bottom":return`M0,0l${t/2},${-t/2}h${(s-t)/2}v${-o}h${-s}v${o}h${(s-t)/2}z`;case"bottom-right":return`M0,0l${-t},${-t}h${t-s}v${-o}h${s}z`;case"left":return`M0,0l${t/2},${-t/2}v${t/2-o/2}h${s}v${o}h${-s}v${t/2-o/2}z`}}function O2(e,t){let n={},i=this.format;i=B2(i,e,"x"),i=B2(i,e,"y"),this.format=i;for(let r in i){let s=i[r];if(!(s===null||s===!1))if(r==="fx"||r==="fy")n[r]=!0;else{let o=Tx(e,r);o&&(n[r]=o)}}for(let r in e){if(r in n||r in i||f6.has(r)||(r==="x"||r==="y")&&e.geometry)continue;let s=Tx(e,r);if(s){if(s.scale==null&&s.defaultScale==="color")continue;n[r]=s}}this.facet&&(t.fx&&!("fx"in i)&&(n.fx=!0),t.fy&&!("fy"in i)&&(n.fy=!0));for(let r in n){let s=this.format[r];if(typeof s=="string"){let o=n[r]?.value??t[r]?.domain()??[];this.format[r]=(Ne(o)?cr:nr)(s)}else if(s===void 0||s===!0){let o=t[r];this.format[r]=o?.bandwidth?Jl(o,o.domain()):xr}}return n}function B2(e,t,n){if(!(n in e))return e;let i=`${n}1`,r=`${n}2`;if((i in e||!(i in t))&&(r in e||!(r in t)))return e;let s=Object.entries(e),o=e[n];return s.splice(s.findIndex(([a])=>a===n)+1,0,[i,o],[r,o]),Object.fromEntries(s)}function m6(e,t,{title:n}){return this.format.title(n.value[e],e)}function*g6(e,t,n,i,r){for(let s in n){if(s==="fx"||s==="fy"){yield{label:np(i,n,s),value:this.format[s](t[s],e)};continue}if(s==="x1"&&"x2"in n||s==="y1"&&"y2"in n)continue;let o=n[s];if(s==="x2"&&"x1"in n)yield{label:z2(i,n,"x"),value:k2(this.format.x2,n.x1,o,e)};else if(s==="y2"&&"y1"in n)yield{label:z2(i,n,"y"),value:k2(this.format.y2,n.y1,o,e)};else{let a=o.value[e],c=o.scale;if(!xi(a)&&c==null)continue;yield{label:np(i,n,s),value:this.format[s](a,e),color:c==="color"?r[s][e]:null,opacity:c==="opacity"?r[s][e]:null}}}}function k2(e,t,n,i){return n.hint?.length?`${e(n.value[i]-t.value[i],i)}`:`${e(t.value[i],i)}–${e(n.value[i],i)}`}function z2(e,t,n){let i=np(e,t,`${n}1`,n),r=np(e,t,`${n}2`,n);return i===r?i:`${i}–${r}`}function np(e,t,n,i=n){let r=t[n],s=e[r?.scale??n];return String(s?.label??r?.label??i)}function Vi(e={}){let{facet:t,style:n,title:i,subtitle:r,caption:s,ariaLabel:o,ariaDescription:a}=e,c=tc(e.className),l=e.marks===void 0?[]:H2(e.marks);l.push(...M6(l));let u=v6(t,e),h=new Map;for(let U of l){let G=W2(U,u,e);G&&h.set(U,G)}let f=new Map;u&&iu(f,[u],e),iu(f,h,e);let d=H2(S6(l,f,e));for(let U of d){let G=W2(U,u,e);G&&h.set(U,G)}l.unshift(...d);let p=fE(f,e);if(p!==void 0){let U=u?Dd(p,u):void 0;for(let q of l){if(q.facet===null||q.facet==="super")continue;let st=h.get(q);st!==void 0&&(st.facetsIndex=q.fx!=null||q.fy!=null?Dd(p,st):U)}let G=new Set;for(let{facetsIndex:q}of h.values())q?.forEach((st,ct)=>{st?.length>0&&G.add(ct)});p.forEach(0<G.size&&G.size<p.length?(q,st)=>q.empty=!G.has(st):q=>q.empty=!1);for(let q of l)if(q.facet==="exclude"){let st=h.get(q);st!==void 0&&(st.facetsIndex=pE(st.facetsIndex))}}for(let U of me.keys())ka(e[U])&&U!=="fx"&&U!=="fy"&&f.set(U,[]);let y=new Map;for(let U of l){if(y.has(U))throw new Error("duplicate mark; each mark must be unique");let{facetsIndex:G,channels:q}=h.get(U)??{},{data:st,facets:ct,channels:$}=U.initialize(G,q,e);w_($,e),y.set(U,{data:st,facets:ct,channels:$})}let m=Wl(iu(f,y,e),e),g=RE(m,l,e);sE(m,g);let v=Fx(m),{fx:S,fy:_}=v,w=S||_?Ux(m,g):g,b=S||_?I6(v,g):g,x=Qa(e),M=x.document,R=xa("svg").call(M.documentElement),E=R;x.ownerSVGElement=R,x.className=c,x.projection=yE(e,w),x.path=function(){return _l(this.projection??SE(v))},x.filterFacets=(U,G)=>Dd(p,{channels:G,groups:Ld(U,G)}),x.getMarkState=U=>{let G=y.get(U),q=h.get(U);return{...G,channels:{...G.channels,...q?.channels}}},x.dispatchValue=U=>{E.value!==U&&(E.value=U,E.dispatchEvent(new x.document.defaultView.Event("input",{bubbles:!0})))};let C=new Set;for(let[U,G]of y)if(U.initializer!=null){let q=U.facet==="super"?b:w,st=U.initializer(G.data,G.facets,G.channels,v,q,x);if(st.data!==void 0&&(G.data=st.data),st.facets!==void 0&&(G.facets=st.facets),st.channels!==void 0){let{fx:ct,fy:$,...at}=st.channels;_6(at),Object.assign(G.channels,at);for(let ft of Object.values(at)){let{scale:ot}=ft;ot!=null&&!iA(me.get(ot))&&(q2(ft,e),C.add(ot))}(ct!=null||$!=null)&&h.set(U,!0)}}if(C.size){let U=new Map;iu(U,y,e,ct=>C.has(ct)),iu(f,y,e,ct=>C.has(ct));let G=R6(Wl(U,e),m),{scales:q,...st}=Fx(G);Object.assign(m,G),Object.assign(v,st),Object.assign(v.scales,q)}let N,B;p!==void 0&&(N={x:S?.domain(),y:_?.domain()},p=hE(p,N),B=dE(S,_,g));for(let[U,G]of y)G.values=U.scale(G.channels,v,x);let{width:I,height:L}=g;Ni(R).attr("class",c).attr("fill","currentColor").attr("font-family","system-ui, sans-serif").attr("font-size",10).attr("text-anchor","middle").attr("width",I).attr("height",L).attr("viewBox",`0 0 ${I} ${L}`).attr("aria-label",o).attr("aria-description",a).call(U=>U.append("style").text(`:where(.${c}) {
  --plot-background: white;
  display: block;
  height: auto;
  height: intrinsic;
  max-width: 100%;
}
:where(.${c} text),
:where(.${c} tspan) {
  white-space: pre;
}`)).call(ec,n);for(let U of l){let{channels:G,values:q,facets:st}=y.get(U);if(p===void 0||U.facet==="super"){let ct=null;if(st&&(ct=st[0],ct=U.filter(ct,G,q),ct.length===0))continue;let $=U.render(ct,v,q,b,x);if($==null)continue;R.appendChild($)}else{let ct;for(let $ of p){if(!(U.facetAnchor?.(p,N,$)??!$.empty))continue;let at=null;if(st){let ot=h.has(U);if(at=st[ot?$.i:0],at=U.filter(at,G,q),at.length===0)continue;!ot&&at===st[0]&&(at=HT(at)),at.fx=$.x,at.fy=$.y,at.fi=$.i}let ft=U.render(at,v,q,w,x);if(ft!=null){(ct??=Ni(R).append("g")).append(()=>ft).datum($);for(let ot of["aria-label","aria-description","aria-hidden","transform"])ft.hasAttribute(ot)&&(ct.attr(ot,ft.getAttribute(ot)),ft.removeAttribute(ot))}}ct?.selectChildren().each(B)}}let k=A2(m,x,e),{figure:F=i!=null||r!=null||s!=null||k.length>0}=e;F&&(E=M.createElement("figure"),E.className=`${c}-figure`,E.style.maxWidth="initial",i!=null&&E.append(V2(M,i,"h2")),r!=null&&E.append(V2(M,r,"h3")),E.append(...k,R),s!=null&&E.append(y6(M,s)),"value"in R&&(E.value=R.value,delete R.value)),E.scale=lE(v.scales),E.legend=S2(m,x,e);let Z=zA();return Z>0&&Ni(R).append("text").attr("x",I).attr("y",20).attr("dy","-1em").attr("text-anchor","end").attr("font-family","initial").text("⚠️").append("title").text(`${Z.toLocaleString("en-US")} warning${Z===1?"":"s"}. Please check the console.`),E}function V2(e,t,n){if(t.ownerDocument)return t;let i=e.createElement(n);return i.append(t),i}function y6(e,t){let n=e.createElement("figcaption");return n.append(t),n}function H2(e){return e.flat(1/0).filter(t=>t!=null).map(x6)}function x6(e){return typeof e.render=="function"?e:new S_(e)}var S_=class extends ge{constructor(t){if(typeof t!="function")throw new TypeError("invalid mark; missing render function");super(),this.render=t}render(){}};function w_(e,t){for(let n in e)q2(e[n],t);return e}function q2(e,t){let{scale:n,transform:i=!0}=e;if(n==null||!i)return;let{type:r,percent:s,interval:o,transform:a=s?c=>c==null?NaN:c*100:fx(o,r)}=t[n]??{};a!=null&&(e.value=de(e.value,a),e.transform=!1)}function _6(e){for(let t in e)wx(t,e[t])}function iu(e,t,n,i=zT){for(let{channels:r}of t.values())for(let s in r){let o=r[s],{scale:a}=o;if(a!=null&&i(a))if(a==="projection"){if(!vE(n)){let c=n.x?.domain===void 0,l=n.y?.domain===void 0;if(c||l){let[u,h]=ME(o);c&&M_(e,"x",u),l&&M_(e,"y",h)}}}else M_(e,a,o)}return e}function M_(e,t,n){let i=e.get(t);i!==void 0?i.push(n):e.set(t,[n])}function v6(e,t){if(e==null)return;let{x:n,y:i}=e;if(n==null&&i==null)return;let r=Zr(e.data);if(r==null)throw new Error("missing facet data");let s={};n!=null&&(s.fx=qa(r,{value:n,scale:"fx"})),i!=null&&(s.fy=qa(r,{value:i,scale:"fy"})),w_(s,t);let o=Ld(r,s);return{channels:s,groups:o,data:e.data}}function W2(e,t,n){if(e.facet===null||e.facet==="super")return;let{fx:i,fy:r}=e;if(i!=null||r!=null){let c=Zr(e.data??i??r);if(c===void 0)throw new Error(`missing facet data in ${e.ariaLabel}`);if(c===null)return;let l={};return i!=null&&(l.fx=qa(c,{value:i,scale:"fx"})),r!=null&&(l.fy=qa(c,{value:r,scale:"fy"})),w_(l,n),{channels:l,groups:Ld(c,l)}}if(t===void 0)return;let{channels:s,groups:o,data:a}=t;if(e.facet!=="auto"||e.data===a)return{channels:s,groups:o};a.length>0&&(o.size>1||o.size===1&&s.fx&&s.fy&&[...o][0][1].size>1)&&Ps(Zr(e.data))===Ps(a)&&Hn(`Warning: the ${e.ariaLabel} mark appears to use faceted data, but isn’t faceted. The mark data has the same length as the facet data and the mark facet option is "auto", but the mark data and facet data are distinct. If this mark should be faceted, set the mark facet option to true; otherwise, suppress this warning by setting the mark facet option to false.`)}function b6(e,t={}){return Jr({...t,x:null,y:null},(n,i,r,s,o,a)=>a.getMarkState(e))}function M6(e){let t=[];for(let n of e){let i=n.tip;if(i){i===!0?i={}:typeof i=="string"&&(i={pointer:i});let{pointer:r,preferredAnchor:s}=i;r=/^x$/i.test(r)?LE:/^y$/i.test(r)?Yx:PE,i=r(b6(n,i)),i.title=null,s===void 0&&(i.preferredAnchor=r===Yx?"left":"bottom");let o=G2(n.data,i);o.facet=n.facet,o.facetAnchor=n.facetAnchor,t.push(o)}}return t}function S6(e,t,n){let{projection:i,x:r={},y:s={},fx:o={},fy:a={},axis:c,grid:l,facet:u={},facet:{axis:h=c,grid:f}=u,x:{axis:d=c,grid:p=d===null?null:l}=r,y:{axis:y=c,grid:m=y===null?null:l}=s,fx:{axis:g=h,grid:v=g===null?null:f}=o,fy:{axis:S=h,grid:_=S===null?null:f}=a}=n;(i||!ka(r)&&!$2("x",e))&&(d=p=null),(i||!ka(s)&&!$2("y",e))&&(y=m=null),t.has("fx")||(g=v=null),t.has("fy")||(S=_=null),d===void 0&&(d=!sp(e,"x")),y===void 0&&(y=!sp(e,"y")),g===void 0&&(g=!sp(e,"fx")),S===void 0&&(S=!sp(e,"fy")),d===!0&&(d="bottom"),y===!0&&(y="left"),g===!0&&(g=d==="top"||d===null?"bottom":"top"),S===!0&&(S=y==="right"||y===null?"left":"right");let w=[];return rp(w,_,p_,a),ip(w,S,h_,"right","left",u,a),rp(w,v,m_,o),ip(w,g,d_,"top","bottom",u,o),rp(w,m,Lo,s),ip(w,y,Zd,"left","right",n,s),rp(w,p,Zl,r),ip(w,d,Jd,"bottom","top",n,r),w}function ip(e,t,n,i,r,s,o){if(!t)return;let a=w6(t);o=T6(a?i:t,s,o);let{line:c}=o;(n===Zd||n===Jd)&&c&&!To(c)&&e.push(U2(A6(o))),e.push(n(o)),a&&e.push(n({...o,anchor:r,label:null}))}function rp(e,t,n,i){!t||To(t)||e.push(n(E6(t,i)))}function w6(e){return/^\s*both\s*$/i.test(e)}function T6(e,t,{line:n=t.line,ticks:i,tickSize:r,tickSpacing:s,tickPadding:o,tickFormat:a,tickRotate:c,fontVariant:l,ariaLabel:u,ariaDescription:h,label:f=t.label,labelAnchor:d,labelArrow:p=t.labelArrow,labelOffset:y}){return{anchor:e,line:n,ticks:i,tickSize:r,tickSpacing:s,tickPadding:o,tickFormat:a,tickRotate:c,fontVariant:l,ariaLabel:u,ariaDescription:h,label:f,labelAnchor:d,labelArrow:p,labelOffset:y}}function A6(e){let{anchor:t,line:n}=e;return{anchor:t,facetAnchor:t+"-empty",stroke:n===!0?void 0:n}}function E6(e,{stroke:t=Wa(e)?e:void 0,ticks:n=C6(e)?e:void 0,tickSpacing:i,ariaLabel:r,ariaDescription:s}){return{stroke:t,ticks:n,tickSpacing:i,ariaLabel:r,ariaDescription:s}}function C6(e){switch(typeof e){case"number":return!0;case"string":return!Wa(e)}return Vn(e)||typeof e?.range=="function"}function sp(e,t){let n=`${t}-axis `;return e.some(i=>i.ariaLabel?.startsWith(n))}function $2(e,t){for(let n of t)for(let i in n.channels){let{scale:r}=n.channels[i];if(r===e||r==="projection")return!0}return!1}function R6(e,t){for(let n in e){let i=e[n],r=t[n];i.label===void 0&&r&&(i.label=r.label)}return e}function I6({fx:e,fy:t},n){let{marginTop:i,marginRight:r,marginBottom:s,marginLeft:o,width:a,height:c}=Id(n),l=e&&X2(e),u=t&&X2(t);return{marginTop:t?u[0]:i,marginRight:e?a-l[1]:r,marginBottom:t?c-u[1]:s,marginLeft:e?l[0]:o,inset:{marginTop:n.marginTop,marginRight:n.marginRight,marginBottom:n.marginBottom,marginLeft:n.marginLeft},width:a,height:c}}function X2(e){let t=e.domain();if(t.length===0)return[0,e.bandwidth()];let n=e(t[0]),i=e(t[t.length-1]);return i<n&&([n,i]=[i,n]),[n,i+e.bandwidth()]}var P6=new Map([["basis",iT],["basis-closed",sT],["basis-open",aT],["bundle",lT],["bump-x",Kw],["bump-y",jw],["cardinal",uT],["cardinal-closed",fT],["cardinal-open",hT],["catmull-rom",pT],["catmull-rom-closed",gT],["catmull-rom-open",xT],["linear",vo],["linear-closed",vT],["monotone-x",ST],["monotone-y",wT],["natural",AT],["step",ET],["step-after",RT],["step-before",CT]]);function T_(e=vo,t){if(typeof e=="function")return e;let n=P6.get(`${e}`.toLowerCase());if(!n)throw new Error(`unknown curve: ${e}`);if(t!==void 0){if("beta"in n)return n.beta(t);if("tension"in n)return n.tension(t);if("alpha"in n)return n.alpha(t)}return n}function Y2(e=ru,t){return typeof e!="function"&&`${e}`.toLowerCase()==="auto"?ru:T_(e,t)}function ru(e){return vo(e)}function L6(e={y:"count"},t={}){[e,t]=F6(e,t);let{x:n,y:i}=t;return D6(U6(n,t,pe),null,null,i,e,nc(t))}function N6(e,t,n={}){if(n?.interval==null)return n;let{reduce:i=Ad}=n,r={filter:null};return n[t]!=null&&(r[t]=i),n[`${t}1`]!=null&&(r[`${t}1`]=i),n[`${t}2`]!=null&&(r[`${t}2`]=i),e(r,n)}function K2(e={}){return N6(L6,"y",Fs(e,"x"))}function D6(e,t,n,i,{data:r=Mx,filter:s=kl,sort:o,reverse:a,...c}={},l={}){e=Z2(e),t=Z2(t),c=B6(c,l),r=t3(r,pe),o=o==null?void 0:j2("sort",o,l),s=s==null?void 0:Q2("filter",s,l),n!=null&&zl(c,"x","x1","x2")&&(n=null),i!=null&&zl(c,"y","y1","y2")&&(i=null);let[u,h]=vi(e),[f,d]=vi(e),[p,y]=vi(t),[m,g]=vi(t),[v,S]=n!=null?[n,"x"]:i!=null?[i,"y"]:[],[_,w]=vi(v),{x:b,y:x,z:M,fill:R,stroke:E,x1:C,x2:N,y1:B,y2:I,domain:L,cumulative:k,thresholds:F,interval:Z,...U}=l,[G,q]=vi(M),[st]=Gn(R),[ct]=Gn(E),[$,at]=vi(st),[ft,ot]=vi(ct);return{..."z"in l&&{z:G||M},..."fill"in l&&{fill:$||R},..."stroke"in l&&{stroke:ft||E},...Ro(U,(rt,J,gt)=>{let lt=Bl(Se(rt,v),gt?.[S]),K=Se(rt,M),It=Se(rt,st),pt=Se(rt,ct),Ut=dA(c,{z:K,fill:It,stroke:pt}),Gt=[],ce=[],oe=lt&&w([]),Xe=K&&q([]),Be=It&&at([]),Ln=pt&&ot([]),xn=e&&h([]),Nn=e&&d([]),z=t&&y([]),Dn=t&&g([]),_e=G6(e,t,rt),ve=0;for(let mt of c)mt.initialize(rt);o&&o.initialize(rt),s&&s.initialize(rt);for(let mt of J){let Ce=[];for(let Lt of c)Lt.scope("facet",mt);o&&o.scope("facet",mt),s&&s.scope("facet",mt);for(let[Lt,Bt]of bx(mt,Ut))for(let[P,T]of bx(Bt,lt))for(let[V,ut]of _e(T))if(Ut&&(ut.z=Lt),!(s&&!s.reduce(V,ut))){Ce.push(ve++),ce.push(r.reduceIndex(V,rt,ut)),lt&&oe.push(P),K&&Xe.push(Ut===K?Lt:K[(V.length>0?V:T)[0]]),It&&Be.push(Ut===It?Lt:It[(V.length>0?V:T)[0]]),pt&&Ln.push(Ut===pt?Lt:pt[(V.length>0?V:T)[0]]),xn&&(xn.push(ut.x1),Nn.push(ut.x2)),z&&(z.push(ut.y1),Dn.push(ut.y2));for(let nt of c)nt.reduce(V,ut);o&&o.reduce(V,ut)}Gt.push(Ce)}return pA(Gt,o,a),{data:ce,facets:Gt}}),...!zl(c,"x")&&(u?{x1:u,x2:f,x:Ha(u,f)}:{x:b,x1:C,x2:N}),...!zl(c,"y")&&(p?{y1:p,y2:m,y:Ha(p,m)}:{y:x,y1:B,y2:I}),..._&&{[S]:_},...Object.fromEntries(c.map(({name:rt,output:J})=>[rt,J]))}}function F6({cumulative:e,domain:t,thresholds:n,interval:i,...r},s){return[r,{cumulative:e,domain:t,thresholds:n,interval:i,...s}]}function U6(e,{cumulative:t,domain:n,thresholds:i,interval:r},s){return e={...gr(e)},e.domain===void 0&&(e.domain=n),e.cumulative===void 0&&(e.cumulative=t),e.thresholds===void 0&&(e.thresholds=i),e.interval===void 0&&(e.interval=r),e.value===void 0&&(e.value=s),e.thresholds=O6(e.thresholds,e.interval),e}function Z2(e){if(e==null)return;let{value:t,cumulative:n,domain:i=cn,thresholds:r}=e,s=o=>{let a=Se(o,t),c;if(Ne(a)||z6(r)){a=de(a,ox,Float64Array);let[u,h]=typeof i=="function"?i(a):i,f=typeof r=="function"&&!Ls(r)?r(a,u,h):r;typeof f=="number"&&(f=Zh(u,h,f)),Ls(f)&&(i===cn&&(u=f.floor(u),h=f.offset(f.floor(h))),f=f.range(u,f.offset(h))),c=f}else{a=dr(a);let[u,h]=typeof i=="function"?i(a):i,f=typeof r=="function"&&!Ls(r)?r(a,u,h):r;if(typeof f=="number")if(i===cn){let d=da(u,h,f);if(isFinite(d))if(d>0){let p=Math.round(u/d),y=Math.round(h/d);p*d<=u||--p,y*d>h||++y;let m=y-p+1;f=new Float64Array(m);for(let g=0;g<m;++g)f[g]=(p+g)*d}else if(d<0){d=-d;let p=Math.round(u*d),y=Math.round(h*d);p/d<=u||--p,y/d>h||++y;let m=y-p+1;f=new Float64Array(m);for(let g=0;g<m;++g)f[g]=(p+g)/d}else f=[u];else f=[u]}else f=_s(u,h,f);else Ls(f)&&(i===cn&&(u=f.floor(u),h=f.offset(f.floor(h))),f=f.range(u,f.offset(h)));c=f}let l=[];if(c.length===1)l.push([c[0],c[0]]);else for(let u=1;u<c.length;++u)l.push([c[u-1],c[u]]);return l.bin=(n<0?H6:n>0?V6:A_)(l,c,a),l};return s.label=ki(t),s}function O6(e,t,n=J2){if(e===void 0)return t===void 0?n:mr(t);if(typeof e=="string"){switch(e.toLowerCase()){case"freedman-diaconis":return E1;case"scott":return Km;case"sturges":return M1;case"auto":return J2}return Ul(e)}return e}function B6(e,t){return hA(e,t,j2)}function j2(e,t,n){return _x(e,t,n,Q2)}function Q2(e,t,n){return vx(e,t,n,t3)}function t3(e,t){return Gl(e,t,k6)}function k6(e){switch(`${e}`.toLowerCase()){case"x":return W6;case"x1":return X6;case"x2":return q6;case"y":return $6;case"y1":return Y6;case"y2":return Z6;case"z":return mA}throw new Error(`invalid bin reduce: ${e}`)}function J2(e,t,n){return Math.min(200,Km(e,t,n))}function z6(e){return XT(e)||Vn(e)&&Ne(e)}function G6(e,t,n){let i=e?.(n),r=t?.(n);return i&&r?function*(s){let o=i.bin(s);for(let[a,[c,l]]of i.entries()){let u=r.bin(o[a]);for(let[h,[f,d]]of r.entries())yield[u[h],{data:n,x1:c,y1:f,x2:l,y2:d}]}}:i?function*(s){let o=i.bin(s);for(let[a,[c,l]]of i.entries())yield[o[a],{data:n,x1:c,x2:l}]}:function*(s){let o=r.bin(s);for(let[a,[c,l]]of r.entries())yield[o[a],{data:n,y1:c,y2:l}]}}function A_(e,t,n){return t=dr(t),i=>{let r=e.map(()=>[]);for(let s of i)r[ma(t,n[s])-1]?.push(s);return r}}function V6(e,t,n){let i=A_(e,t,n);return r=>{let s=i(r);for(let o=1,a=s.length;o<a;++o){let c=s[o-1],l=s[o];for(let u of c)l.push(u)}return s}}function H6(e,t,n){let i=A_(e,t,n);return r=>{let s=i(r);for(let o=s.length-2;o>=0;--o){let a=s[o+1],c=s[o];for(let l of a)c.push(l)}return s}}function e3(e,t){let n=(+e+ +t)/2;return e instanceof Date?new Date(n):n}var W6={reduceIndex(e,t,{x1:n,x2:i}){return e3(n,i)}},$6={reduceIndex(e,t,{y1:n,y2:i}){return e3(n,i)}},X6={reduceIndex(e,t,{x1:n}){return n}},q6={reduceIndex(e,t,{x2:n}){return n}},Y6={reduceIndex(e,t,{y1:n}){return n}},Z6={reduceIndex(e,t,{y2:n}){return n}};var J6={ariaLabel:"area",strokeWidth:1,strokeLinecap:"round",strokeLinejoin:"round",strokeMiterlimit:1},op=class extends ge{constructor(t,n={}){let{x1:i,y1:r,x2:s,y2:o,z:a,curve:c,tension:l}=n;super(t,{x1:{value:i,scale:"x"},y1:{value:r,scale:"y"},x2:{value:s,scale:"x",optional:!0},y2:{value:o,scale:"y",optional:!0},z:{value:Ga(n),optional:!0}},n,J6),this.z=a,this.curve=T_(c,l)}filter(t){return t}render(t,n,i,r,s){let{x1:o,y1:a,x2:c=o,y2:l=a}=i;return se("svg:g",s).call(Ue,this,r,s).call(Oe,this,n,0,0).call(u=>u.selectAll().data(kd(t,[o,a,c,l],this,i)).enter().append("path").call(Ee,this).call(Bd,this,i).attr("d",Zw().curve(this.curve).defined(h=>h>=0).x0(h=>o[h]).y0(h=>a[h]).x1(h=>c[h]).y1(h=>l[h]))).node()}};function ap(e,t){let{x:n=hr,...i}=K2(t);return new op(e,jd(Kd({...i,x1:n,x2:void 0},n===hr?"y2":"y")))}var K6={ariaLabel:"bar"},E_=class extends ge{constructor(t,n,i={},r=K6){super(t,n,i,r),tu(this,i),eu(this,i)}render(t,n,i,r,s){let{rx:o,ry:a,rx1y1:c,rx1y2:l,rx2y1:u,rx2y2:h}=this,f=this._x(n,i,r),d=this._y(n,i,r),p=this._width(n,i,r),y=this._height(n,i,r);return se("svg:g",s).call(Ue,this,r,s).call(this._transform,this,n).call(m=>m.selectAll().data(t).enter().call(c||l||u||h?g=>g.append("path").call(Ee,this).call(nu,f,d,n3(f,p),n3(d,y),this).call(un,this,i):g=>g.append("rect").call(Ee,this).attr("x",f).attr("width",p).attr("y",d).attr("height",y).call(Ot,"rx",o).call(Ot,"ry",a).call(un,this,i))).node()}_x(t,{x:n},{marginLeft:i}){let{insetLeft:r}=this;return n?s=>n[s]+r:i+r}_y(t,{y:n},{marginTop:i}){let{insetTop:r}=this;return n?s=>n[s]+r:i+r}_width({x:t},{x:n},{marginRight:i,marginLeft:r,width:s}){let{insetLeft:o,insetRight:a}=this,c=n&&t?t.bandwidth():s-i-r;return Math.max(0,c-o-a)}_height({y:t},{y:n},{marginTop:i,marginBottom:r,height:s}){let{insetTop:o,insetBottom:a}=this,c=n&&t?t.bandwidth():s-i-r;return Math.max(0,c-o-a)}};function n3(e,t){return typeof e=="function"&&typeof t=="function"?n=>e(n)+t(n):typeof e=="function"?n=>e(n)+t:typeof t=="function"?n=>e+t(n):e+t}var cp=class extends E_{constructor(t,n={},i){let{x1:r,x2:s,y:o}=n;super(t,{x1:{value:r,scale:"x"},x2:{value:s,scale:"x"},y:{value:o,scale:"y",type:"band",optional:!0}},n,i)}_transform(t,n,{x:i}){t.call(Oe,n,{x:i},0,0)}_x({x:t},{x1:n,x2:i},{marginLeft:r}){let{insetLeft:s}=this;return zi(t)?r+s:o=>Math.min(n[o],i[o])+s}_width({x:t},{x1:n,x2:i},{marginRight:r,marginLeft:s,width:o}){let{insetLeft:a,insetRight:c}=this;return zi(t)?o-r-s-a-c:l=>Math.max(0,Math.abs(i[l]-n[l])-a-c)}};function lp(e,t={}){return _d(t)||(t={...t,y:hr,x2:pe}),new cp(e,jl(Vd(Kl(t))))}var j6={ariaLabel:"dot",fill:"none",stroke:"currentColor",strokeWidth:1.5};function Q6(e){return e.sort===void 0&&e.reverse===void 0?lA({channel:"-r"},e):e}var up=class extends ge{constructor(t,n={}){let{x:i,y:r,r:s,rotate:o,symbol:a=bo,frameAnchor:c}=n,[l,u]=Pe(o,0),[h,f]=oA(a),[d,p]=Pe(s,h==null?3:4.5);super(t,{x:{value:i,scale:"x",optional:!0},y:{value:r,scale:"y",optional:!0},r:{value:d,scale:"r",filter:So,optional:!0},rotate:{value:l,optional:!0},symbol:{value:h,scale:"auto",optional:!0}},Q6(n),j6),this.r=p,this.rotate=u,this.symbol=f,this.frameAnchor=Ns(c);let{channels:y}=this,{symbol:m}=y;if(m){let{fill:g,stroke:v}=y;m.hint={fill:g?g.value===m.value?"color":"currentColor":this.fill??"currentColor",stroke:v?v.value===m.value?"color":"currentColor":this.stroke??"none"}}}render(t,n,i,r,s){let{x:o,y:a}=n,{x:c,y:l,r:u,rotate:h,symbol:f}=i,{r:d,rotate:p,symbol:y}=this,[m,g]=_r(this,r),v=y===bo,S=u?void 0:d*d*Math.PI;return Da(d)&&(t=[]),se("svg:g",s).call(Ue,this,r,s).call(Oe,this,{x:c&&o,y:l&&a}).call(_=>_.selectAll().data(t).enter().append(v?"circle":"path").call(Ee,this).call(v?w=>{w.attr("cx",c?b=>c[b]:m).attr("cy",l?b=>l[b]:g).attr("r",u?b=>u[b]:d)}:w=>{w.attr("transform",ic`translate(${c?b=>c[b]:m},${l?b=>l[b]:g})${h?b=>` rotate(${h[b]})`:p?` rotate(${p})`:""}`).attr("d",u&&f?b=>{let x=er();return f[b].draw(x,u[b]*u[b]*Math.PI),x}:u?b=>{let x=er();return y.draw(x,u[b]*u[b]*Math.PI),x}:f?b=>{let x=er();return f[b].draw(x,S),x}:(()=>{let b=er();return y.draw(b,S),b})())}).call(un,this,i)).node()}};function fp(e,{x:t,y:n,...i}={}){return i.frameAnchor===void 0&&([t,n]=Bi(t,n)),new up(e,{...i,x:t,y:n})}var t8={ariaLabel:"line",fill:"none",stroke:"currentColor",strokeWidth:1.5,strokeLinecap:"round",strokeLinejoin:"round",strokeMiterlimit:1},hp=class extends ge{constructor(t,n={}){let{x:i,y:r,z:s,curve:o,tension:a}=n;super(t,{x:{value:i,scale:"x"},y:{value:r,scale:"y"},z:{value:Ga(n),optional:!0}},n,t8),this.z=s,this.curve=Y2(o,a),Xl(this,n)}filter(t){return t}project(t,n,i){this.curve!==ru&&super.project(t,n,i)}render(t,n,i,r,s){let{x:o,y:a}=i,{curve:c}=this;return se("svg:g",s).call(Ue,this,r,s).call(Oe,this,n).call(l=>l.selectAll().data(kd(t,[o,a],this,i)).enter().append("path").call(Ee,this).call(Bd,this,i).call(UE,this,i,s).attr("d",c===ru&&s.projection?e8(s.path(),o,a):Iy().curve(c).defined(u=>u>=0).x(u=>o[u]).y(u=>a[u]))).node()}};function e8(e,t,n){return t=dr(t),n=dr(n),i=>{let r=[],s=[r];for(let o of i)o===-1?(r=[],s.push(r)):r.push([t[o],n[o]]);return e({type:"MultiLineString",coordinates:s})}}function ac(e,{x:t,y:n,...i}={}){return[t,n]=Bi(t,n),new hp(e,{...i,x:t,y:n})}ge.prototype.plot=function({marks:e=[],...t}={}){return Vi({...t,marks:[...e,this]})};function Os(e,t,n){let i=Ht("div",{class:"told",hidden:!0});e.append(i);function r(s){let o=t.getBoundingClientRect(),a=s.clientX-o.left,c=n(a,s.clientY-o.top);if(i.hidden=c===null,c===null)return;i.replaceChildren(Ht("b",{},c.head),...c.rows.map(n8));let l=c.x??a,u=l+12+i.offsetWidth>o.width?l-12-i.offsetWidth:l+12;i.style.left=`${Math.max(0,u)}px`,i.style.top=`${Math.max(0,s.clientY-o.top-i.offsetHeight-12)}px`}t.addEventListener("pointermove",r),t.addEventListener("pointerdown",r),t.addEventListener("pointerleave",()=>{i.hidden=!0})}function n8({name:e,value:t,role:n}){let i=Ht("span",{class:"row"},Ht("i",{class:"dot"}),e,Ht("span",{class:"value"},t));return n?i.firstChild.style.background=Ze(n):i.firstChild.remove(),i}var i3={stacked:26,beside:14},i8=.36;function r3(e,t,n,i){let r=t.series.map(l=>({...l,values:n(l.values)})),s=r.flatMap(({name:l,role:u,values:h})=>t.names.map((f,d)=>({bar:d,name:l,role:u,value:h[d]}))),o=Math.min(i*i8,16+Math.max(...t.names.map(an))),a=r8(t,r,s.filter(({value:l})=>Number.isFinite(l)),i,o);e.replaceChildren(a),e.parentElement.querySelector(":scope > .key")?.remove(),r.length>1&&e.before(Ki(r.map(l=>({...l,style:"patch"}))));let c=a.scale(t.stacked?"y":"fy");return Os(e,a,(l,u)=>{let h=t.names.findIndex((d,p)=>u>=c.apply(p)&&u<c.apply(p)+c.bandwidth);if(h<0)return null;let f=s.filter(d=>d.bar===h);return{head:t.names[h],rows:f.map(({name:d,role:p,value:y})=>({name:d,role:p,value:Fr(y)}))}}),{}}function r8(e,t,n,i,r){let s={label:null,tickFormat:u=>Dr(e.names[u],r-12),tickSize:0},o=e.stacked?1:t.length,a=44+e.names.length*(e.stacked?i3.stacked:i3.beside*o+10),c=u=>Ze(u.role),l=ti(n,{x:"value",[e.stacked?"y":"fy"]:"bar",...e.stacked?{}:{y:"name"},text:u=>o1(u.value),textAnchor:"start",dx:5,fill:"var(--quiet)"});return Vi({width:i,height:a,marginLeft:r,marginRight:48,marginTop:6,marginBottom:36,style:{fontFamily:"inherit",fontSize:`${12}px`,background:"none",overflow:"visible"},x:{label:e.x_label,labelArrow:"none",labelAnchor:"right",ticks:Math.round(i/110),zero:!0},...e.stacked?{y:{...s,domain:e.names.map((u,h)=>h),padding:.25}}:{fy:{...s,domain:e.names.map((u,h)=>h),padding:.2},y:{axis:null,domain:t.map(({name:u})=>u),padding:.1}},marks:[Zl({stroke:"var(--rule)",strokeOpacity:1,ticks:Math.round(i/110)}),e.stacked?lp(n,{x:"value",y:"bar",fill:c,order:t.map(({name:u})=>u),z:"name",insetRight:1}):lp(n,{x:"value",fy:"bar",y:"name",fill:c}),t.length===1||!e.stacked?l:null,es([0],{stroke:"var(--faint)"})]})}var s8=30,o8=200,C_=({style:e})=>e==="steps"?"step-after":"linear";function dp(e,t={}){let{x:n,low:i,high:r,role:s,style:o}=e;return i===null||r===null?null:o==="points"?es(n,{x:n,y1:i,y2:r,stroke:Ze(s),strokeOpacity:.6,clip:!0,...t}):ap(n,{x:n,y1:i,y2:r,fill:Ze(s),fillOpacity:.2,curve:C_(e),clip:!0,...t})}function s3(e,t={}){let{x:n,y:i,role:r}=e;return ap(n,{x:n,y1:0,y2:i,fill:Ze(r),fillOpacity:.2,curve:C_(e),clip:!0,...t})}function pp(e,t={}){let{x:n,y:i,role:r,style:s}=e,o=Ze(r);if(s==="points")return fp(n,{x:n,y:i,fill:o,r:n.length>o8?1.6:3,...t});let a=ac(n,{x:n,y:i,stroke:o,strokeWidth:1.75,strokeDasharray:s==="dashed"?"5 4":void 0,strokeLinejoin:"round",curve:C_(e),clip:!0,...t});return n.length<=s8&&s==="line"?[a,fp(n,{x:n,y:i,fill:o,r:2.5,...t})]:a}var a8=.5;function Bs(e,t){let n=i=>i===null?null:t(i);return e.map(i=>({...i,x:t(i.x),y:t(i.y),low:n(i.low),high:n(i.high)}))}function R_(e,t){let n=-1;for(let i=0;i<e.length;i+=1)Number.isFinite(e[i])&&(n<0||Math.abs(e[i]-t)<Math.abs(e[n]-t))&&(n=i);return n}function c8({x:e,y:t,style:n},i,r=0){if(n==="points"){let a=R_(e,i);return a>=0&&Math.abs(e[a]-i)<=r?t[a]:NaN}let s=e.findIndex(a=>a>i),o=(s<0?e.length:s)-1;return o<0?NaN:e[o]===i?t[o]:s<0?NaN:n==="steps"?t[o]:t[o]+(i-e[o])/(e[s]-e[o])*(t[s]-t[o])}var l8=({x:e})=>e.length>1&&e[0]===e[1];function o3({y:e}){return e.findLast(Number.isFinite)??NaN}function ks(e){let t=1/0,n=-1/0;for(let i of e)for(let r of i??[])Number.isFinite(r)&&(r<t&&(t=r),r>n&&(n=r));return t<=n?[t,n]:[0,1]}function mp({x_label:e,x_levels:t=[]},n,i,r){let s=i.invert(Math.min(Math.max(r,i.range[0]),i.range[1])),o=n.filter(f=>!l8(f)),a=o.map(f=>f.x[R_(f.x,s)]),c=t.length>0,l=c?Math.round(s):a[R_(a,s)]??s,u=f=>Fr(c8(f,l,c?a8:0)),h=o.map(f=>({name:f.name,value:u(f),role:f.role}));return{head:t[l]??jc(e,Fr(l)),rows:h,x:i.apply(l)}}var u8=24;function a3(e,t,n){if(e.length===0)return[];let i=n/(t[1]-t[0]||1),r=e.filter(({at:o,until:a})=>a>o),s=e.filter(({at:o,until:a})=>a<=o);return[x_(r,{x1:"at",x2:"until",fill:(o,a)=>a%2?"var(--stretch-other)":"var(--stretch)",title:"text"}),es(s,{x:"at",stroke:"var(--faint)",strokeDasharray:"2 3",title:"text"}),ti(f8(r,s,i),{x:"at",text:"shown",frameAnchor:"top",textAnchor:"start",dx:1,dy:-4,fill:"var(--quiet)",fontSize:11,lineAnchor:"bottom"})]}function f8(e,t,n){let i=[...e,...t].sort((o,a)=>o.at-a.at),r=[],s=-1/0;return i.forEach((o,a)=>{let c=i.slice(a+1).find(({at:h})=>h>o.at)?.at??Math.max(o.until,o.at+1e9),l=(Math.min(c,o.until>o.at?o.until:c)-o.at)*n-8;if(o.at*n<s||l<u8)return;let u=Dr(o.text,l);s=o.at*n+an(u)+8,r.push({at:o.at,shown:u})}),r}function gp(e,t,n,i){let r=document.createElementNS(e.namespaceURI,"line");r.setAttribute("class","play-head"),r.setAttribute("y1",i[0]),r.setAttribute("y2",i[1]),e.append(r),e.classList.add("timed");let s=({clientX:o})=>n.seek(t.invert(o-e.getBoundingClientRect().left));return e.addEventListener("click",s),{showTime(o){let[a,c]=t.domain;r.style.visibility=o<a||o>c?"hidden":"visible",r.setAttribute("transform",`translate(${t.apply(o)},0)`)}}}var h8=620,d8=6,p8=.26,m8=140,g8=14,yp={top:26,right:14,bottom:36,left:46};function l3(e,t,n,i,r){let s=Bs(t.lines,n),o=!e.closest(".multiples"),a=o&&i>=h8&&s.length>1&&s.length<=d8&&Vm(s)<=p8*i,c={...yp,top:yp.top+(t.marks.length>0?g8:0),right:yp.right+(a?Vm(s):0)},l=c3(t,s,i,c);e.replaceChildren(l);let u=16+ah(l);u>c.left&&(c.left=u,l=c3(t,s,i,c),e.replaceChildren(l)),e.parentElement.querySelector(":scope > .key")?.remove(),a?v8(l,s,i-c.right):o&&s.length>1&&e.before(Ki(s)),b8(l,c.right-yp.right);let h=l.scale("x");return Os(e,l,f=>mp(t,s,h,f)),!t.timed||!r?{}:gp(l,h,r,l.scale("y").range)}function c3(e,t,n,{top:i,right:r,bottom:s,left:o}){let[a,c]=e.limits??_8(ks(t.flatMap(({y:f,low:d,high:p})=>[f,d,p]))),l=n-o-r,u=y8(e.x_levels,l),h=Math.round(Math.min(300,Math.max(190,n*.42)))+u.height;return Vi({width:n,height:h,marginTop:i,marginRight:r,marginBottom:s+u.height,marginLeft:o,style:{fontFamily:"inherit",fontSize:`${12}px`,background:"none",overflow:"visible"},x:{...x8(e,t),...u.options,label:e.x_label,labelArrow:"none",labelAnchor:"right"},y:{domain:[a,c],label:e.y_label,labelArrow:"none",ticks:Math.round(h/55)},marks:[...a3(e.marks,ks(t.map(f=>f.x)),l),Lo({stroke:"var(--rule)",strokeOpacity:1,ticks:Math.round(h/55)}),a<0&&c>0?Yl([0],{stroke:"var(--faint)"}):null,...t.map(f=>dp(f)),...t.map(f=>pp(f))]})}function y8(e,t){let n=Math.max(0,...e.map(an));if(n<=t/e.length-6||e.length===0)return{options:{},height:0};let i=Math.min(m8,n);return{options:{tickRotate:-90,tickFormat:r=>Dr(e[r]??"",i),labelOffset:i+28},height:i}}function x8(e,t){let n=t.map(a=>a.x);if(e.x_levels.length>0)return{domain:[-.4,e.x_levels.length-1+.4],ticks:e.x_levels.map((c,l)=>l),tickFormat:c=>e.x_levels[c]??"",tickSize:0};let i=[...n,e.marks.flatMap(({at:a,until:c})=>[a,c])];if(e.x_log)return{type:"log",domain:ks(i.map(a=>[...a].filter(c=>c>0)))};let r=n.every(a=>a.every(c=>Number.isInteger(c))),[s,o]=ks(i);return{domain:s===o?[s-1,o+1]:[s,o],...r&&o-s<=12?{ticks:o-s,tickFormat:"d"}:{}}}function _8([e,t]){let n=t>e?.04*(t-e):Math.abs(t)*.1||1;return[e===0?0:e-n,t===0?0:t+n]}function v8(e,t,n){let i=e.scale("y"),[r,s]=i.range,a=t.map(c=>i.apply(o3(c))).map(c=>Number.isFinite(c)?Math.min(r,Math.max(s,c)):r);c1(a,s,r).forEach((c,l)=>{e.append(ei("line",{x1:n+6,x2:n+6+ch,y1:c,y2:c,class:"of-end",stroke:Ze(t[l].role)}));let u=ei("text",{class:"end",x:n+12+ch,y:c,dy:"0.32em"});u.textContent=t[l].name,e.append(u)})}function b8(e,t){let n=e.querySelector('[aria-label="x-axis label"]');n?.setAttribute("transform",`translate(${-t},0) ${n.getAttribute("transform")??""}`)}var M8=40,S8=.3,u3=140;function f3(e,t,n,i){let r=n(t.values),s=t.x_levels.length,o=Array.from(r,(h,f)=>w8(t,h,f%s,Math.floor(f/s))),a=Bs(t.contours,n),c=E8(t,o,a,i);e.replaceChildren(c),e.parentElement.querySelectorAll(":scope > .key, :scope > .ramp").forEach(h=>h.remove()),t.low!==null&&e.before(C8(t)),a.length>0&&e.before(Ki(a));let[l,u]=[c.scale("x"),c.scale("y")];return Os(e,c,(h,f)=>{let[d,p]=[Math.round(l.invert(h)),Math.round(u.invert(f))],y=t.told[p]?.[d];if(y===void 0)return null;let[m,g]=[jc(t.x_label,t.x_levels[d]),jc(t.y_label,t.y_levels[p])];return{head:`${m}, ${g}`,rows:[{name:y,value:""}]}}),{}}function w8(e,t,n,i){let r=Math.min(1,Math.max(0,(t-e.low)/(e.high-e.low||1))),s=e.better==="low"?r:1-r,o=e.low!==null&&Number.isFinite(t);return{column:n,row:i,text:e.cells[i][n],fill:o?T8(s):"var(--no-value)",ink:o?A8(s):"var(--quiet)"}}function T8(e){let[t,n,i]=e<.5?["good","middling",e*2]:["middling","bad",e*2-1];return`color-mix(in oklab, var(--heat-${n}) ${(i*100).toFixed(1)}%, var(--heat-${t}))`}function A8(e){return e<.5?"var(--on-good)":e<.88?"var(--on-middling)":"var(--on-bad)"}function E8(e,t,n,i){let[r,s]=[e.x_levels.length,e.y_levels.length],o=Math.min(i*S8,18+Math.max(...e.y_levels.map(an))),a=(i-o-8)/r,c=t.every(({text:d})=>an(d)<a-4),l=Math.min(u3,Math.max(...e.x_levels.map(an))),u=l>a-6,h=Math.ceil((u?14:1)/a),f=u?l+30:38;return Vi({width:i,height:26+f+M8*s,marginLeft:o,marginRight:8,marginTop:26,marginBottom:f,style:{fontFamily:"inherit",fontSize:`${12}px`,background:"none",overflow:"visible"},x:{domain:[-.5,r-.5],label:e.x_label,labelArrow:"none",labelAnchor:"right",ticks:e.x_levels.map((d,p)=>p).filter(d=>d%h===0),tickSize:0,tickFormat:d=>Dr(e.x_levels[d],u3),tickRotate:u?-90:0,labelOffset:f-4},y:{domain:[-.5,s-.5],label:e.y_label,labelArrow:"none",tickSize:0,ticks:e.y_levels.map((d,p)=>p),tickFormat:d=>Dr(e.y_levels[d],o-12)},marks:[y_(t,{x1:({column:d})=>d-.5,x2:({column:d})=>d+.5,y1:({row:d})=>d-.5,y2:({row:d})=>d+.5,fill:{value:"fill",scale:null},inset:1,rx:2}),c?ti(t,{x:"column",y:"row",text:"text",fill:{value:"ink",scale:null}}):null,...n.flatMap(({x:d,y:p,role:y,style:m})=>[ac(d,{x:d,y:p,stroke:"var(--paper)",strokeWidth:5,strokeOpacity:.8,clip:!0}),ac(d,{x:d,y:p,stroke:Ze(y),strokeWidth:2.25,clip:!0,strokeDasharray:m==="dashed"?"6 4":void 0})])]})}function C8(e){let[t,n]=e.better==="low"?[e.low,e.high]:[e.high,e.low];return Ht("p",{class:"ramp"},`${e.value_label} `,Ht("span",{},Fr(t)),Ht("i",{class:"scale","aria-hidden":!0}),Ht("span",{},Fr(n)))}var I_={least:36,most:80,all:200},lc=18,ns={top:22+lc,right:14,bottom:36,left:46};function d3(e,t,n,i,r){let s=Bs(t.lines,n),o=Math.round(Math.min(I_.most,Math.max(I_.least,I_.all/s.length))),a=ns.top+s.length*(o+lc)-lc+ns.bottom,c=h3(t,s,{width:i,height:a,stripHigh:o,left:ns.left});e.replaceChildren(c);let l=16+ah(c);l>ns.left&&(c=h3(t,s,{width:i,height:a,stripHigh:o,left:l}),e.replaceChildren(c));let u=c.scale("x");return Os(e,c,h=>mp(t,s,u,h)),!t.timed||!r?{}:gp(c,u,r,[a-ns.bottom,ns.top])}function h3(e,t,{width:n,height:i,stripHigh:r,left:s}){let o=e.limits??ks(t.flatMap(f=>[f.y,f.low,f.high])),[a,c]=o[0]===o[1]?[o[0],o[0]+1]:o,l=R8(a,c),u=ks(t.map(f=>f.x)),h=a<=0&&c>0;return Vi({width:n,height:i,marginTop:ns.top,marginRight:ns.right,marginBottom:ns.bottom,marginLeft:s,style:{fontFamily:"inherit",fontSize:`${12}px`,background:"none",overflow:"visible"},x:{domain:u[0]===u[1]?[u[0]-1,u[1]+1]:u,label:e.x_label,labelArrow:"none",labelAnchor:"right"},y:{domain:[a,c],label:null,ticks:l},fy:{domain:t.map((f,d)=>d),axis:null,paddingOuter:0,paddingInner:lc/(r+lc)},marks:[Lo({stroke:"var(--rule)",strokeOpacity:1,ticks:l}),ti([e.y_label],{frameAnchor:"top-left",lineAnchor:"bottom",textAnchor:"start",dx:4-s,dy:-lc-4,fy:()=>0}),ti(t,{text:"name",fy:(f,d)=>d,frameAnchor:"top-left",lineAnchor:"bottom",textAnchor:"start",dy:-3,fontWeight:600}),...t.flatMap((f,d)=>{let p={fy:()=>d};return[h?s3(f,p):null,dp(f,p),pp(f,p)]})]})}function R8(e,t){let n=10**Math.floor(Math.log10(t-e));return Number.isFinite(n)?[Math.ceil(e/n)*n,Math.floor(t/n)*n]:[e,t]}var I8={chart:l3,bars:r3,heat_map:f3,strips:d3},P8="300px";function p3(e,t,n,i){let r=new Map;for(let{element:l,part:u}of e){let h=l.querySelector(".plot");r.set(h,{place:h,part:u,width:0,plot:null})}function s(l){let u=Math.floor(l.place.clientWidth);u===0||u===l.width||(l.width=u,l.plot=I8[l.part.kind](l.place,l.part,t,u,i?n:null),l.plot.showTime?.(n.state.time))}let o=new Set,a=new ResizeObserver(l=>l.forEach(({target:u})=>{o.has(u)&&s(r.get(u))})),c=new IntersectionObserver(l=>l.forEach(({target:u,isIntersecting:h})=>{h?o.add(u):o.delete(u),h&&s(r.get(u)),h&&r.get(u).plot?.showTime?.(n.state.time)}),{rootMargin:P8});for(let l of r.keys())a.observe(l),c.observe(l);n.listen((l,{time:u})=>{l==="time"&&o.forEach(h=>r.get(h).plot?.showTime?.(u))}),addEventListener("beforeprint",()=>r.forEach(s))}var L8=7,Mi=16,su=20,N8=["fill","fill-opacity","stroke","stroke-width","stroke-opacity","stroke-dasharray","stroke-linejoin","opacity","font-family","font-size","font-weight","text-anchor","dominant-baseline","paint-order","visibility"];function x3(e,t,n){for(let{element:i,part:r}of e)i.append(m3(i,[["CSV","the numbers",()=>_3(i,"csv","text/csv",D8(r,n))],["SVG","the figure",()=>y3(i,B8(r))]]));for(let i of t)i.append(m3(i,[["SVG","the figure",()=>y3(i,[])]]))}function m3(e,t){let n=e.querySelector("figcaption").textContent;return Ht("div",{class:"save"},...t.map(([i,r,s])=>Ht("button",{type:"button",class:"quiet",onclick:s,title:`Save ${r} as ${i}`,"aria-label":`Save ${r} of "${n}" as ${i}`},i)))}function D8(e,t){return{chart:g3,strips:g3,bars:F8,heat_map:U8}[e.kind](e,t).map(i=>i.map(O8).join(",")).join(`\r
`)+`\r
`}function g3({lines:e,x_label:t,y_label:n,x_levels:i=[]},r){let s=Bs(e,r),o=s.some(({low:c})=>c!==null);return[["series",t,n,...o?["lowest","highest"]:[]],...s.flatMap(({name:c,x:l,y:u,low:h,high:f})=>Array.from(l,(d,p)=>[c,i[d]??uc(d),uc(u[p]),...o?[uc(h?.[p]),uc(f?.[p])]:[]]))]}function F8({names:e,series:t,x_label:n},i){let r=t.flatMap(({name:s,values:o})=>e.map((a,c)=>[a,s,uc(i(o)[c])]));return[["name","series",n],...r]}function U8({x_label:e,y_label:t,value_label:n,x_levels:i,y_levels:r,values:s},o){let a=Array.from(o(s),(c,l)=>[i[l%i.length],r[Math.floor(l/i.length)],uc(c)]);return[[e,t,n],...a]}function uc(e){return Number.isFinite(e)?String(Number(e.toPrecision(L8))):""}function O8(e){return/[",\r\n]/.test(e)?`"${e.replaceAll('"','""')}"`:e}function B8({kind:e,lines:t,series:n,contours:i}){if(e==="strips")return[];let r=t??n??i??[];return r.length>1||e==="heat_map"?r:[]}function y3(e,t){let n=e.querySelector(".plot > svg, .picture > svg"),{dataset:i}=document.documentElement,r=i.theme;i.theme="light";try{let{width:s,height:o}=n.getBoundingClientRect();_3(e,"svg","image/svg+xml",new XMLSerializer().serializeToString(k8(e,n,s,o,t)))}finally{r===void 0?delete i.theme:i.theme=r}}function k8(e,t,n,i,r){let s=[n+2*Mi,i+2*Mi+su],o=ei("svg",{xmlns:"http://www.w3.org/2000/svg","font-family":"system-ui, sans-serif","font-size":12}),a=ei("text",{x:Mi,y:Mi+8,"font-size":15,"font-weight":600});a.textContent=e.querySelector("figcaption").textContent,o.append(ei("rect",{width:"100%",height:"100%",fill:"white"}),a);let c=r.length>0&&!t.querySelector(".end")?z8(e,r,n):null;c&&(o.append(c.group),s[1]+=c.height);let l=V8(t);for(let[u,h]of Object.entries({x:Mi,y:Mi+su+(c?.height??0),width:n,height:i}))l.setAttribute(u,h);return o.append(l),o.setAttribute("width",s[0]),o.setAttribute("height",s[1]),o.setAttribute("viewBox",`0 0 ${s[0]} ${s[1]}`),o}function z8(e,t,n){let i=ei("g"),[r,s]=[Mi,Mi+su+6];for(let{name:o,role:a}of t){let c=22+an(o);r>Mi&&r+c>Mi+n&&([r,s]=[Mi,s+su]);let l=ei("text",{x:r+15,y:s+4});l.textContent=o,i.append(ei("rect",{x:r,y:s-5,width:10,height:10,fill:G8(e,a)}),l),r+=c+10}return{group:i,height:s-Mi-su+12}}function G8(e,t){return getComputedStyle(e).getPropertyValue(Ze(t).slice(4,-1)).trim()}function V8(e){let t=e.cloneNode(!0),n=[t,...t.querySelectorAll("*")];return[e,...e.querySelectorAll("*")].forEach((i,r)=>{let s=getComputedStyle(i);for(let{name:o,value:a}of[...n[r].attributes])a.includes("var(--")&&n[r].removeAttribute(o);for(let o of N8)n[r].style.setProperty(o,s.getPropertyValue(o))}),t.querySelectorAll(".play-head, style").forEach(i=>i.remove()),t}function _3(e,t,n,i){let r=decodeURIComponent(location.pathname.split("/").at(-1)).replace(/\.html?$/i,"")||"report",s=URL.createObjectURL(new Blob([i],{type:`${n};charset=utf-8`}));Ht("a",{href:s,download:`${r}_${e.id.replace("part-","")}.${t}`}).click(),setTimeout(()=>URL.revokeObjectURL(s),1e4)}document.documentElement.classList.add("scripted");var zs=u1(document.getElementById("numbers").textContent),ou=Y_(zs.shown),v3=[...document.querySelectorAll("[data-part]")].map(e=>({element:e,part:zs.parts.get(e.dataset.part)})),P_=v3.filter(({part:e})=>e.kind==="hand"),L_=v3.filter(({part:e})=>e.kind!=="hand");Z_(document.querySelector(".contents"));q_(document.getElementById("bar"),zs.trials,ou,P_.length>0);for(let{element:e,part:t}of P_)l1(e.querySelector(".stage"),K_(t,zs.array),ou);for(let e of document.querySelectorAll(".multiples")){let{part:t}=L_.find(({element:n})=>e.contains(n));t.kind==="chart"&&t.lines.length>1&&e.prepend(Ki(t.lines))}zs.at!==null&&ou.open(zs.at);x3(L_,document.querySelectorAll("figure.drawing"),zs.array);$_();p3(L_,zs.array,ou,P_.length>0);ou.listen((e,{trial:t})=>{if(e==="trial")for(let n of document.querySelectorAll("[data-trial]"))n.hidden=Number(n.dataset.trial)!==t});})();
